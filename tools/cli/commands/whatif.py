"""``mukca whatif``: would a suspected flaw of a suspected size explain what was recorded?"""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from ....errors import fixed
from ....solver import diagnostics
from ....solver.calibration import SolveOptions
from ....solver.diagnostics import FLAWS, WhatIf
from ... import cli

UNITS = {"mm": 1e3, "deg": 57.29577951308232, "%": 100.0, "": 1.0}
LIST = "\n".join(
    f"  {word:10} {kinds[0].unit or 'no size':8} {', '.join(kind.name for kind in kinds)}"
    for word, kinds in FLAWS.items()
)
"""Kinds of faults, with their units and the causes that tell them."""


class _WhatifOptions(cli.RobotOptions, cli.JsonOption):
    data: Sequence[Path] = cli.argument("placements", "DATA")
    fault: str = cli.option(
        ..., "KIND [NAME] [@SAMPLE] [SIZE], as 'sag 3mm' or 'base@6 5mm'", "FAULT"
    )
    settings: SolveOptions = cli.part(
        SolveOptions,
        "distance known distance_deviation zeros payload gravity repeatability_mm flange_poses "
        "leave_out",
    )


def run_whatif(options: _WhatifOptions, terminal: cli.Terminal) -> int:
    """Answer first; then the two patterns, sizes and odds, and what else fits."""
    flaw = diagnostics.Flaw.parse(options.fault)
    robot = options.load_robot()
    settings = options.settings.validated()
    measured, premises = cli.measured_of(options.data, robot, settings, sockets=1)
    result = diagnostics.what_if(robot, measured, flaw, **premises)
    terminal.say(_answer(result), "")
    terminal.say(*(f"  {name:44}{value}" for name, value in _rows(result)), "")
    if result.rivals and result.answer != "size":
        terminal.say("Other explanations that fit as well or better:")
        terminal.say(*(f"  {text}" for text, _ in result.rivals))
    terminal.say(f"Next: {_next(result)}")
    terminal.emit(result.as_dict())
    return {"yes": 0, "unseen": 3}.get(result.answer, 1)


def _answer(result: WhatIf) -> str:
    """Return the answer in a sentence or two."""
    observed = _size(result, result.size_observed, result.deviation)
    if result.answer == "no" and result.rivals and result.log_odds > 0:
        return "NO: another flaw explains the recordings far better."
    return {
        "yes": f"YES: {_named(result)} would explain what was recorded.",
        "size": f"NO, not of that size: its pattern is there, but of {observed}.",
        "unseen": "CANNOT BE TOLD: at these postures a fit hides so small a flaw.",
        "no": "NO: the pattern of that flaw is not in the recordings.",
    }[result.answer]


def _named(result: WhatIf) -> str:
    """Return the flaw as it was typed, and where it would be if it was not said."""
    keys = ("joint", "placement", "place")
    where = [f"{result.where[key]}" for key in keys if result.where.get(key)]
    if result.where.get("number"):
        where[-1] = f"sample {result.where['number']}"
    elif result.where.get("place"):
        where[-1] = f"sample {result.where['place']} of socket {result.where['socket']}"
    return f"{result.fault!r} ({', '.join(where)})" if where else repr(result.fault)


def _size(result: WhatIf, size: float | None, deviation: float | None = None) -> str:
    """Return a size in its unit, with its deviation if it has one."""
    if size is None:
        return "-"
    factor = UNITS[result.unit]
    spread = "" if deviation is None else f" +- {factor * deviation:.2g}"
    return f"{factor * size:.3g}{spread} {result.unit}".strip()


def _rows(result: WhatIf) -> list[tuple[str, str]]:
    """Return the patterns of the flaw and of the recordings, side by side."""
    rows = [("suspected", f"{_named(result)}, cause {result.cause}")]
    if result.unit:
        rows += [
            ("its size", _size(result, result.size)),
            (
                "size in the recordings",
                _size(result, result.size_observed, result.deviation),
            ),
        ]
    if result.pattern:
        rows += [
            ("it moves the ball by up to", f"{1e3 * result.moves:.3f} mm"),
            ("a fit to perfect data with it leaves", f"{1e3 * result.pattern:.3f} mm"),
            ("a fit to the recordings leaves", f"{1e3 * result.observed:.3f} mm"),
            ("and with the flaw taken out", f"{1e3 * result.remains:.3f} mm"),
        ]
    if result.alike is not None:
        rows.append(("the patterns are alike by (1: the same)", f"{result.alike:.2f}"))
    odds = result.log_odds / 2.302585092994046
    return [*rows, ("odds against nothing wrong", f"10^{fixed(odds, 1, '+')}")]


def _next(result: WhatIf) -> str:
    """Return the step that follows from the answer."""
    tell = next(k for k in chain(*FLAWS.values()) if k.name == result.cause).tell
    if result.answer in ("yes", "size"):
        return f"{tell} (docs: causes/{result.cause})"
    if result.answer == "unseen":
        return f"{tell}; the recordings have nothing to tell of it"
    return "mukca check names what the recordings look like"

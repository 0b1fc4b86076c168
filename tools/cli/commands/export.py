"""``mukca export``: write a calibration as other programs read it."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Literal

from ....errors import MukcaError
from ....solver import calibration
from ....solver.calibration import UsageError
from ... import export
from ...export import format_table
from .. import JsonOption, PayloadOptions, Terminal, argument, for_each_arm, option

FORMATS = format_table()
LIST = "\n".join(f"  {name:<11} {format_.line}" for name, format_ in FORMATS.items())


class _ExportOptions(PayloadOptions, JsonOption):
    calibration: Path = argument(
        "calibration.json or arms.json, or its folder", "CALIBRATION"
    )
    to: str = option(..., "one of the formats below", "FORMAT", choices=FORMATS)
    out: Path = option(..., "file to write", "FILE")
    flange: str | None = option(
        None,
        "(c, urdf) the link whose pose C gives, or that carries tools (default: the one that "
        "carries the ball)",
        "LINK",
    )
    tool: Sequence[str] = option(
        (),
        "(urdf) add a link, fixed to the flange: metres and radians; may be repeated",
        "NAME=X,Y,Z,R,P,Y",
        repeated=True,
    )
    like: Path | None = option(
        None,
        "(ur) the file that ur_calibration wrote, whose hash is kept; (mjcf, usd) the model to "
        "correct; (lerobot, pal, trossen) the arm's present file",
        "FILE",
    )
    joints: str | None = option(
        None,
        "(mjcf, usd) how the model calls the joints: names in chain order, between commas; or one "
        "word in which * is the URDF's name, as in left/*",
        "NAMES",
    )
    servos: Literal["feetech", "dynamixel"] | None = option(
        None, "(lerobot) the make of the arm's servos"
    )
    rows: int | None = option(
        None, "(joint-table) offsets of each joint (default: 64)", "N"
    )
    serial_number: str | None = option(
        None, "serial number of the arm (default: as noted while recording)", "TEXT"
    )
    force: bool = option(False, "overwrite FILE")


@for_each_arm
def run_export(options: _ExportOptions, terminal: Terminal) -> int:
    """Write the files, and print what the format cannot express."""
    tools = _tools(options.tool)
    loaded = calibration.load_calibration(options.calibration)
    if loaded.document.distorted:
        places = ", ".join(loaded.document.distorted)
        terminal.warn(
            f"{options.calibration}: the model does not reproduce the sockets' distance at "
            f"{places}; it was accepted by --accept-distorted"
        )
    with suppress(MukcaError):  # not every file that can be exported can be judged
        if loaded.verdict.status == "fail":
            terminal.warn(
                f"{options.calibration}: {loaded.verdict.title}: do not use it yet"
            )
    names = ("serial_number", "force", "like", "joints", "servos", "flange", "rows")
    settings = {name: getattr(options, name) for name in names}
    exported = export.export(
        loaded,
        options.to,
        options.out,
        **settings,
        tools=tools,
        payload=options.carried,
    )
    wrote = (f"Wrote {file}" for file in exported.outputs.values())
    terminal.say(*map(str, exported.losses), *exported.lines, *wrote)
    losses = [asdict(loss) for loss in exported.losses]
    terminal.emit({"format": options.to, "outputs": exported.outputs, "losses": losses})
    return 0


def _tools(words: Sequence[str]) -> dict[str, tuple[float, ...]]:
    tools: dict[str, tuple[float, ...]] = {}
    for word in words:
        name, _, place = word.partition("=")
        try:
            numbers = tuple(map(float, place.split(",")))
        except ValueError:
            numbers = ()
        if not name or name in tools or not numbers:
            raise UsageError(
                f"--tool {word}: give each a name of its own, a place in metres and a turn in "
                "radians, as in --tool gripper=0,0,0.12,0,0,1.57"
            )
        tools[name] = numbers
    return tools

"""``mukca plan``: what bases, placements and samples would bring."""

import itertools
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from ....errors import fixed
from ....solver import assessment, design, results
from ....solver.calibration import UsageError
from ...report.plots import from_above, to_scale
from .. import OutputOptions, RobotOptions, Terminal, WorkerOptions, option


class _PlanOptions(RobotOptions, WorkerOptions, OutputOptions):
    placements: int = option(3, "predict up to so many placements", "N", between=(1, 8))
    samples: int = option(12, "samples in each socket", "K", between=(3, 100))
    distance: Sequence[float] = option(
        (0.1, 0.15, 0.05),
        "distance of the base's sockets, in metres",
        "M",
        between=(0.01, 1),
    )
    turn: float | None = option(
        None,
        "turn no joint farther than this from where a session begins, and say what that costs",
        "DEG",
        between=(30, 360),
    )
    out: Path | None = option(None, "write a picture of the placements", "FILE.svg")
    force: bool = option(False, "overwrite the picture", needs="out")


def run_plan(options: _PlanOptions, terminal: Terminal) -> int:
    """Show the table, and write the picture."""
    if options.out:
        if options.out.suffix.lower() != ".svg":
            raise UsageError(
                f"--out {options.out}: the picture is an SVG; end its name in .svg"
            )
        results.refuse_existing(
            options.out.parent, [options.out.name], force=options.force
        )
    robot = options.load_robot()
    work = partial(
        design.plan, robot, placements=options.placements, samples=options.samples
    )
    plans: list[design.Plan] = []
    for turn in [None] if options.turn is None else [None, options.turn]:
        with terminal.progress(len(options.distance)) as progress:
            plans += options.workers.map(
                partial(work, turn=turn),
                options.distance,
                lambda i: progress(f"sockets {1e3 * options.distance[i]:g} mm apart"),
            )
    _show(plans, options, terminal)
    if options.out:
        results.write_files(
            options.out.parent, {options.out.name: _picture(robot.name, plans[0])}
        )
        terminal.say(f"Picture: {options.out}")
    advice = design.curve_advice(robot)
    if advice:
        terminal.say(advice)
    rows = [asdict(row) for row in plans]
    document = {"robot": options.robot, "samples": options.samples, "plans": rows}
    terminal.emit({**document, "advice": advice})
    return 0


_STYLE = """
svg { background: white; font: 12px sans-serif; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.grid { stroke: #ddd; }
.robot { fill: #444; }
.base { fill: #1f5fbf; }
.number { fill: white; }
"""


def _picture(robot: str, planned: "design.Plan") -> bytes:
    """Return the placements seen from above, as SVG, in their order."""
    seen = from_above([(0, 0, 0), *planned.places])
    labels = "to the right of the robot, m", "before it, m"
    panel = to_scale(f"{robot}, from above", seen, labels, room=0.15)
    panel.dot(0, 0, "robot", size=14)
    for number, (sideways, before) in enumerate(seen[1:].tolist(), 1):
        panel.dot(sideways, before, "base", size=10)
        x = panel.x(sideways)
        y = panel.y(before)
        panel.text(x, y + 4, str(number), "middle number")
        panel.text(x, y + 24, f"{1e3 * planned.predicted[number - 1]:.2f} mm", "middle")
    return panel.file(_STYLE)


def _show(
    plans: "list[design.Plan]", options: _PlanOptions, terminal: Terminal
) -> None:
    counts = range(1, options.placements + 1)
    heads = [
        "sockets apart",
        *(assessment.plural(count, "placement") for count in counts),
    ]
    rows: list[list[str]] = []
    for row in plans:
        cells = [f"{1e3 * error:.2f}" for error in row.predicted]
        cells += ["-"] * (options.placements - len(cells))
        within = "" if row.turn is None else f", within {row.turn:g} deg"
        rows.append([f"{1e3 * row.distance:g} mm{within}", *cells])
    title = f"Predicted error of distances [mm], {options.samples} samples a socket"
    terminal.tabulate(title, heads, rows)
    first, *_ = places = plans[0].places
    moves = [design.in_words(*pair) for pair in itertools.pairwise(places)]
    texts = [
        "x {} y {} z {} m in the frame of the robot's base".format(
            *(fixed(value, 2, "+") for value in first)
        )
    ]
    terminal.say(f"Placements, in this order: {', then '.join([*texts, *moves])}.")

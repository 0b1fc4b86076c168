"""``mukca plan``: what bases, placements and samples would bring, before the first print."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ....solver import assessment, design, results
from .. import OutputOptions, RobotOptions, Terminal, WorkerOptions, option, table


@dataclass(frozen=True, kw_only=True)
class Options(RobotOptions, WorkerOptions, OutputOptions):
    """Options of ``mukca plan``."""

    placements: int = option("up to so many", "N", 3, between=(1, 8))
    samples: int = option("in each socket", "K", 12, between=(3, 100))
    distance: Sequence[float] = option(
        "of the base's sockets, in metres", "M", (0.1, 0.15, 0.05), between=(0.01, 1)
    )
    turn: float | None = option(
        "no joint farther than this from where a session begins, for cables, and what that costs",
        "DEG",
        between=(30, 360),
    )
    out: Path | None = option("write a picture of the placements", "FILE.svg", group="output")
    force: bool = option("overwrite the picture", default=False, group="output")


def run_plan(options: Options, terminal: Terminal) -> int:
    """Show the table, and write the picture."""
    if options.out:
        results.refuse_existing(options.out.parent, [options.out.name], force=options.force)
    robot = options.load_robot()
    work = partial(design.plan, robot, placements=options.placements, samples=options.samples)
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
            options.out.parent, {options.out.name: design.picture(robot, plans[0]).encode()}
        )
        terminal.say(f"Picture: {options.out}")
    advice = design.curve_advice(robot)
    if advice:
        terminal.say(advice)
    rows = [one.as_dict() for one in plans]
    document = {"robot": options.robot, "samples": options.samples, "plans": rows}
    terminal.emit({**document, "advice": advice})
    return 0


def _show(plans: "list[design.Plan]", options: Options, terminal: Terminal) -> None:
    counts = range(1, options.placements + 1)
    heads = ["sockets apart", *(assessment.plural(count, "placement") for count in counts)]
    rows: list[list[str]] = []
    for one in plans:
        cells = [f"{1e3 * error:.2f}" for error in one.errors]
        cells += ["-"] * (options.placements - len(cells))
        within = "" if one.turn is None else f", within {one.turn:g} deg"
        rows.append([f"{1e3 * one.distance:g} mm{within}", *cells])
    title = f"Predicted error of distances [mm], {options.samples} samples a socket"
    terminal.console.print(table(title, heads, rows))
    first, *_ = places = plans[0].places
    moves = [design.in_words(*pair) for pair in itertools.pairwise(places)]
    texts = ["x {:+.2f} y {:+.2f} z {:+.2f} m in the frame of the robot's base".format(*first)]
    terminal.say(f"Placements, in this order: {', then '.join([*texts, *moves])}.")

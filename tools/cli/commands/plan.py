"""``mukca plan``: what bases, placements and samples would bring, before the first print."""

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ...parallel import add_workers, workers_of
from .. import Terminal, add_robot, robot_of
from ..robot_arguments import UsageError

if TYPE_CHECKING:
    from ....solver.design import Plan

EXAMPLE = """example:
  mukca plan --robot panda
  mukca plan --robot ur5e --placements 4 --samples 10 --out plan.svg

Predicted are errors of distances in the workspace, one standard deviation, median over random
pairs of poses: for an arm as far from its model as calibrations expect, 0.1 mm of noise, a base
measured with a caliper, and well chosen poses."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add_robot(parser)
    add = parser.add_argument
    add("--placements", type=int, default=3, metavar="N", help="up to so many (default: 3)")
    add("--samples", type=int, default=12, metavar="K", help="in each socket (default: 12)")
    add("--distance", type=float, nargs="+", default=[0.05, 0.1, 0.2], metavar="M", help="of the "
        "base's sockets, in metres (default: 0.05 0.1 0.2)")  # fmt: skip
    add("--out", type=Path, metavar="FILE.svg", help="write a picture of the placements")
    add("--force", action="store_true", help="overwrite the picture")
    add("--json", action="store_true", help="print one JSON object, SI units")
    add_workers(parser)


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Show the table, and write the picture."""
    from ....solver.design import picture
    from ....solver.design.plan_placements import plan
    from ....solver.results import refuse_existing, write_files

    for name, low, high in (("placements", 1, 8), ("samples", 3, 100)):
        if not low <= getattr(arguments, name) <= high:
            raise UsageError(f"--{name} {getattr(arguments, name)}: expected {low} to {high}")
    for distance in arguments.distance:
        if not 0.01 <= distance <= 1:
            raise UsageError(f"--distance {distance:g}: expected 0.01 to 1")
    if arguments.out:
        refuse_existing(arguments.out.parent, [arguments.out.name], force=arguments.force)
    robot = robot_of(arguments)
    work = partial(plan, robot, placements=arguments.placements, samples=arguments.samples)
    with terminal.progress(len(arguments.distance)) as progress:
        plans = workers_of(arguments).map(
            work,
            arguments.distance,
            lambda i: progress(f"sockets {1e3 * arguments.distance[i]:g} mm apart"),
        )
    _show(plans, arguments, terminal)
    if arguments.out:
        write_files(arguments.out.parent, {arguments.out.name: picture(robot, plans[0]).encode()})
        terminal.say(f"Picture: {arguments.out}")
    if arguments.json:
        terminal.emit(
            {
                "robot": arguments.robot,
                "samples": arguments.samples,
                "plans": [one.as_dict() for one in plans],
            }
        )
    return 0


def _show(plans: "list[Plan]", arguments: argparse.Namespace, terminal: Terminal) -> None:
    from rich.table import Table

    table = Table(
        title=f"Predicted error of distances \\[mm], {arguments.samples} samples a socket"
    )
    table.add_column("sockets apart")
    for count in range(1, arguments.placements + 1):
        table.add_column(f"{count} placement{'s' * (count > 1)}", justify="right")
    for one in plans:
        cells = [f"{1e3 * error:.2f}" for error in one.errors]
        cells += ["-"] * (arguments.placements - len(cells))
        table.add_row(f"{1e3 * one.distance:g} mm", *cells)
    terminal.console.print(table)
    places = ", then ".join("x {:+.2f} y {:+.2f} z {:+.2f} m".format(*p) for p in plans[0].places)
    terminal.say(f"Placements, in this order: {places}; in the frame of the robot's base.")

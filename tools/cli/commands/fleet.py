"""``mukca fleet``: calibrate many arms, and compare them on one page."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.results import refuse_existing, write_files
from ...parallel import add_workers, workers_of
from .. import Terminal, add_repeatability, add_robot

if TYPE_CHECKING:
    from ...fleet import ArmFolder, FleetDocument

EXAMPLE = """example:
  mukca fleet fleet --robot panda --distance 0.0501 --out fleet-report
  mukca fleet fleet --robot panda --out fleet-report --cluster tcp://10.0.0.7:8786

A fleet is a folder with one folder an arm; in it are the arm's placements, or one folder of
placements for each date, as in fleet/arm-7/2026-06-01/front. An arm's own robot.urdf, beside
them, goes before --robot. The last placement of a session is held out of the fit. The workers of
a cluster read DIR and write --out by the same paths.

Exit status 1: an arm does not pass, or has drifted."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("folder", type=Path, metavar="DIR", help="one folder an arm")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="where to write")
    parser.add_argument("--force", action="store_true", help="overwrite what is there")
    add_robot(parser)
    parser.add_argument("--method", choices=("auto", "paper"), default="auto")
    parser.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres (default: the recording's, or 0.05; 1 mm "
        "wrong makes an arm 2 %% too long)",
    )
    add_repeatability(parser)
    add_workers(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Calibrate all arms, and write the page."""
    from ....solver.calibration import learn_types
    from ....solver.results import encode
    from ...fleet import (
        FORMAT,
        FleetDocument,
        calibrate_arm,
        compare_parameters,
        find_arms,
        last_sessions,
    )
    from ...report.page import fleet_page

    workers = workers_of(arguments)
    refuse_existing(arguments.out, force=arguments.force)
    items = [_arm(arguments, folder) for folder in find_arms(arguments.folder)]
    with terminal.progress(len(items)) as progress:
        arms = workers.map(calibrate_arm, items, lambda i: progress(items[i].folder.name))
    result = FleetDocument(format=FORMAT, arms=tuple(arms), parameters=compare_parameters(arms))
    page = fleet_page(result).encode("utf-8", "replace")
    files = {"fleet.html": page, "fleet.json": encode(result, indent=1)}
    learned = learn_types(Path(last.outputs["calibration"]) for last in last_sessions(arms))
    if learned.types:
        files["elasticity.json"] = encode(learned, indent=1)
    written = write_files(arguments.out, files)
    show(result, terminal)
    if learned.types:
        terminal.say(f"Elasticity, for --type-prior: {written['elasticity.json']}")
    terminal.say(f"Report: {written['fleet.html']}")
    if arguments.json:
        terminal.emit(result)
    return 1 if any(arm.again is not None for arm in arms) else 0


def _arm(arguments: argparse.Namespace, folder: Path) -> "ArmFolder":
    from ...fleet import ArmFolder

    return ArmFolder(
        folder=folder.resolve(),
        out=(arguments.out / folder.name).resolve(),
        robot=_path_or_name(arguments.robot),
        base=arguments.base,
        tip=arguments.tip,
        flange=arguments.flange,
        ball=None if arguments.ball is None else tuple(arguments.ball),
        method=arguments.method,
        distance=arguments.distance,
        repeatability_mm=arguments.repeatability_mm,
    )


def _path_or_name(robot: str) -> str:
    """Return a URDF's whole path, since a cluster's workers stand elsewhere."""
    return str(Path(robot).resolve()) if Path(robot).is_file() else robot


def show(result: "FleetDocument", terminal: Terminal) -> None:
    """Print a row for each arm, and what to do."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from ...report.page import line_of, summary_of

    table = Table(box=SIMPLE_HEAD)
    for head in ("arm", "last session", "nominal", "calibrated", "verdict"):
        table.add_column(head, justify="right" if head in ("nominal", "calibrated") else "left")
    for arm in result.arms:
        table.add_row(*map(Text, line_of(arm)))
    terminal.console.print(table)
    for arm in result.arms:
        if arm.again is not None:
            terminal.say(f"{arm.name}: {arm.again}")
    terminal.say(f"{summary_of(result)}.")

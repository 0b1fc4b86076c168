"""``mukca validate``: measure a calibration on other recordings."""

import argparse
from pathlib import Path

from ..arguments import measure_all
from ..terminal import Terminal

EXAMPLE = """example:
  mukca validate calibrated/calibration.json recordings/left recordings/right"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("calibration", type=Path, metavar="CALIBRATION", help="calibration.json")
    parser.add_argument("data", nargs="+", type=Path, metavar="DATA", help="placements")
    parser.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres (default: the recording's, or 0.05)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Show nominal and calibrated errors on placements; those trained on are marked."""
    from ..calibration.calibration import load_calibration

    calibration = load_calibration(arguments.calibration)
    data = measure_all(arguments.data, calibration.robot, arguments.distance, sockets=1)
    for line in (line for measured in data for line in measured.warnings):
        terminal.warn(line)
    errors = calibration.errors_of(data)
    terminal.console.print(errors.table())
    if errors.summary.train is not None:
        terminal.say("Placements with role `train` were fitted: their errors prove little.")
    if arguments.json:
        document = calibration.result.as_dict()
        kept = ("robot", "method", "optimizer", "iterations", "converged", "solve_seconds")
        terminal.emit({**{key: document[key] for key in kept}, **errors.as_dict(), "outputs": {}})
    return 0

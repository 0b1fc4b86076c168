"""``mukca validate``: measure a calibration on other recordings."""

import argparse
from pathlib import Path

from .. import Terminal, add_repeatability, measure_all
from .report import metres

EXAMPLE = """example:
  mukca validate calibrated/calibration.json recordings/left recordings/right

Exit status 1: the calibration does not hold there."""


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
    add_repeatability(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Show nominal and calibrated errors on placements; those trained on are marked."""
    from ....solver.assessment import Options, judge_drift, limits_of
    from ....solver.calibration import load_calibration
    from .. import metrics_table

    repeatability = metres("--repeatability-mm", arguments.repeatability_mm)
    calibration = load_calibration(arguments.calibration)
    data = measure_all(arguments.data, calibration.robot, arguments.distance, sockets=1)
    for line in (line for measured in data for line in measured.warnings):
        terminal.warn(line)
    errors = calibration.errors_of(data)
    terminal.console.print(metrics_table(errors.placements, errors.summary))
    if errors.summary.train is not None:
        terminal.say("Placements with role `train` were fitted: their errors prove little.")
    limits = limits_of(
        calibration.document, str(arguments.calibration), Options(repeatability=repeatability)
    )
    new = errors.summary.test or errors.summary.train
    assert new is not None  # there is data
    held_out = [m for m in data if not calibration.was_trained_on(m)]
    drift = judge_drift(calibration.document, calibration.calibrated, new, held_out or data, limits)
    terminal.say(drift.text)
    if arguments.json:
        document = calibration.result.as_dict()
        kept = ("robot", "method", "optimizer", "iterations", "converged", "solve_seconds")
        said = {key: document[key] for key in kept}
        verdict = drift.as_dict()
        terminal.emit({**said, **errors.as_dict(), "outputs": {}, "verdict": verdict})
    return 1 if drift.status == "invalid" else 0

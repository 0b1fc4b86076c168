"""``mukca validate``: measure a calibration on other recordings."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import measure_all
from ..terminal import Terminal

if TYPE_CHECKING:
    from ...solver.data.measurements import Measurement

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
    import msgspec

    from ...solver.calibrated import calibration_of, load_document
    from ...solver.result import figures, models_of
    from ..console_tables import metrics_table
    from ..documents.calibration import PlacementErrors, Summaries

    document = load_document(arguments.calibration)
    calibration = calibration_of(document, str(arguments.calibration))
    data = measure_all(arguments.data, calibration.robot, arguments.distance, sockets=1)
    for line in (line for measured in data for line in measured.warnings):
        terminal.warn(line)
    train = [m for m in data if _was_trained_on(m, document)]
    test = [m for m in data if m not in train]
    result: dict[str, Any] = {
        **{key: document[key] for key in ("robot", "method", "optimizer", "iterations")},
        **{key: document[key] for key in ("converged", "solve_seconds")},
        **figures(models_of(calibration), train, test),
        "outputs": {},
    }
    placements = msgspec.convert(result["placements"], tuple[PlacementErrors, ...])
    summary = msgspec.convert(result["summary"], Summaries)
    terminal.console.print(metrics_table(placements, summary))
    if train:
        terminal.say("Placements with role `train` were fitted: their errors prove little.")
    if arguments.json:
        terminal.emit(result)
    return 0


def _was_trained_on(measured: "Measurement", document: Mapping[str, Any]) -> bool:
    """Tell whether the calibration was fitted to these very samples, wherever they lie now."""
    positions = [list(sample.position) for sample in measured.placement.samples]
    return any(
        row["role"] == "train" and [s["position"] for s in row["samples"]] == positions
        for row in document["data"]
    )

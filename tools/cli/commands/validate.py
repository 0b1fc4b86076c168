"""``mukca validate``: measure a calibration on other recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.calibration import SolveOptions
from .. import JsonOption, Terminal, argument, measure_all, part, table
from .report import metres

if TYPE_CHECKING:
    from ....solver.calibration import Errors


@dataclass(frozen=True, kw_only=True)
class Options(JsonOption):
    """Options of ``mukca validate``."""

    calibration: Path = argument("calibration.json", "CALIBRATION")
    data: Sequence[Path] = argument("placements", "DATA")
    settings: SolveOptions = part(SolveOptions, "distance", "repeatability_mm")


def run(options: Options, terminal: Terminal) -> int:
    """Show nominal and calibrated errors on placements; those trained on are marked."""
    from ....solver.assessment import Options, judge_drift, limits_of
    from ....solver.calibration import load_calibration
    from ....solver.results import beyond_words

    repeatability = metres(options.settings.validated().repeatability_mm)
    calibration = load_calibration(options.calibration)
    data = measure_all(options.data, calibration.robot, options.settings.distance, sockets=1)
    curves, names = calibration.document.curves, calibration.robot.joint_names
    for m in data:
        terminal.warn(*m.warnings, *beyond_words(curves, names, m.positions, m.name))
    errors = calibration.errors_of(data)
    show_errors(errors, terminal)
    if errors.summary.train is not None:
        terminal.say("Placements with role `train` were fitted: their errors prove little.")
    limits = limits_of(
        calibration.document, str(options.calibration), Options(repeatability=repeatability)
    )
    held_out = [m for m in data if not calibration.was_trained_on(m)]
    new = errors.summary.test
    drift = judge_drift(calibration.document, calibration.calibrated, new, held_out, limits)
    terminal.say(drift.text)
    if options.json:
        document = calibration.result.as_dict()
        kept = ("robot", "method", "optimizer", "iterations", "converged", "solve_seconds")
        said = {key: document[key] for key in kept}
        verdict = drift.as_dict()
        terminal.emit({**said, **errors.as_dict(), "outputs": {}, "verdict": verdict})
    return drift.verdict.exit_status


def show_errors(errors: "Errors", terminal: Terminal) -> None:
    """Show the nominal and the calibrated errors of each placement, and the summaries."""
    from ....solver.calibration import HEADS

    rows = errors.table()
    bold = [number for number, (summed, _) in enumerate(rows) if summed]
    cells = [cells for _, cells in rows]
    terminal.console.print(table(errors.title, HEADS, cells, bold=bold, no_wrap=True))

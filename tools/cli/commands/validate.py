"""``mukca validate``: measure a calibration on other recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....solver import calibration, partial, results
from ....solver.calibration import SolveOptions
from .. import OutputOptions, Terminal, argument, for_each_arm, measure_all, part, table
from .report import emit_with_page, metres


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca validate``."""

    calibration: Path = argument("calibration.json or arms.json, or its folder", "CALIBRATION")
    data: Sequence[Path] = argument("placements", "DATA")
    settings: SolveOptions = part(SolveOptions, "distance", "repeatability_mm", "flange_poses")


def run(options: Options, terminal: Terminal) -> int:
    """Show nominal and calibrated errors on placements; those trained on are marked."""
    return for_each_arm(options, terminal, _run)


def _run(options: Options, terminal: Terminal) -> int:
    options.check_out()
    calibrated = calibration.load_calibration(options.calibration)
    document, robot = calibrated.document, calibrated.robot
    settings = options.settings
    flange = settings.flange_poses
    data = measure_all(options.data, robot, settings.distance, sockets=1, flange_poses=flange)
    for m in data:
        beyond = results.beyond_words(document.curves, robot.joint_names, m.positions, m.name)
        terminal.warn(*beyond)
    found = partial.what_changed(
        calibrated,
        [m.placement for m in data],
        distance=options.settings.distance,
        repeatability=metres(options.settings.validated().repeatability_mm),
    )
    terminal.warn(*found.warnings)
    errors, notes = found.errors, list[str]()
    show_errors(errors, terminal)
    if errors.summary.train is not None:
        notes.append("Placements with role `train` were fitted: their errors prove little.")
    if found.verdict.exit_status == 1:
        notes.append("mukca check --calibration tells what changed, and how sure that is.")
    terminal.say(found.text, *notes)
    whole = calibrated.result.as_dict()
    keys = ("robot", "method", "optimizer", "iterations", "converged", "solve_seconds")
    said = {**{key: whole[key] for key in keys}, **errors.as_dict(), "verdict": found.as_dict()}
    emit_with_page(options, terminal, (found.text, *notes, repr(errors)), said)
    return found.verdict.exit_status


def show_errors(errors: "calibration.Errors", terminal: Terminal) -> None:
    """Show the nominal and the calibrated errors of each placement, and the summaries."""
    rows = errors.table()
    bold = [number for number, (summed, _) in enumerate(rows) if summed]
    cells = [cells for _, cells in rows]
    terminal.console.print(table(errors.title, calibration.HEADS, cells, bold=bold, no_wrap=True))

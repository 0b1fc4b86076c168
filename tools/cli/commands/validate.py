"""``mukca validate``: a calibration on other recordings, and the tools of two arms."""

from collections.abc import Sequence
from pathlib import Path

from ....solver import calibration, partial, results
from ....solver.calibration import SolveOptions
from ....solver.identification import data
from ... import cli, recording
from .calibration_tables import show_errors
from .report import emit_with_page, metres
from .tool_to_tool import compare_tools, document_of, lines_of, status_of

MOST_PLACEMENTS = 3
"""Placements whose largest errors and distances are shown; of more it is the mean errors."""


class ValidateOptions(cli.TableOptions, cli.OutputOptions):
    """Options of ``mukca validate``, which ``mukca check --calibration`` has, too."""

    calibration: Path
    data: Sequence[Path]
    stood: str = ""
    tool_to_tool: bool = False
    limit_mm: float | None = None
    settings: SolveOptions = cli.part(
        SolveOptions,
        "distance payload repeatability_mm flange_poses as_recorded leave_out",
    )


def run_validate(options: ValidateOptions, terminal: cli.Terminal) -> int:
    """Validate each arm by itself, or the distance of two arms' tools."""
    if not options.tool_to_tool:
        return _validate(options, terminal)
    options.check_out()
    rows, hints = compare_tools(
        options.calibration, options.data, options.settings, terminal
    )
    limit = metres(options.limit_mm)
    lines = [*lines_of(rows, limit), *hints]
    terminal.say(*lines)
    emit_with_page(options, terminal, lines, document_of(rows, limit))
    return 1 if status_of(rows, limit) == "fail" else 0


@cli.for_each_arm
def _validate(options: ValidateOptions, terminal: cli.Terminal) -> int:
    """Show errors on placements, those trained on marked; then what changed, and the next step."""
    options.check_out()
    calibrated = calibration.load_calibration(options.calibration)
    robot = calibrated.robot
    settings = options.settings
    placements = cli.read_data(options.data, settings, options.table)
    placements = settings.payloads.carried_by(placements, others=True)
    if settings.distance is None:
        placements = [partial.on_base_of(calibrated, one) for one in placements]
    for placement in placements:
        m = data.measure(placement, robot, settings.distance, sockets=1)
        where = robot.joint_names, m.positions, m.name
        terminal.warn(*results.beyond_words(calibrated.document.curves, *where))
    validity, done = recording.judged(
        calibrated, placements, settings, stood=options.stood
    )
    terminal.warn(*map(str, done))
    terminal.warn(*validity.warnings)
    errors = validity.errors
    for finding in validity.findings:
        terminal.warn(str(finding), level=finding.level)
    told = [f"{finding.level}: {finding}" for finding in validity.findings]
    is_proved = errors.summary.test is not None
    lines = [*validity.odds, *validity.not_shown] if is_proved else []
    terminal.say(validity.text)
    show_errors(errors, terminal, short=len(errors) > MOST_PLACEMENTS)
    if is_proved and errors.summary.train:
        lines.append(
            "The calibration was trained on some of these placements: their errors prove little."
        )
    terminal.say(*lines)
    fit = calibrated.result.as_dict()
    keys = ("robot", "method", "optimizer", "iterations", "converged", "solve_seconds")
    result = {
        **{key: fit[key] for key in keys},
        **errors.as_dict(),
        "probabilities": validity.probabilities,
        "likeliest": validity.likeliest,
        "verdict": validity.as_dict(),
    }
    lines = [validity.text, *told, *lines, repr(errors)]
    emit_with_page(options, terminal, lines, result)
    return validity.verdict.exit_status

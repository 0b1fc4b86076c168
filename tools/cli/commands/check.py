"""``mukca check``: recordings by themselves."""

from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from itertools import chain
from pathlib import Path
from typing import Any

from .... import recorder
from ....solver import assessment, calibration, data, design, diagnostics, results
from ....solver.calibration import SolveOptions, UsageError
from ... import cli
from .report import emit_with_page
from .validate import ValidateOptions, run_validate

_SOURCES = {
    "given": "as given",
    "recording": "by the recording",
    "default": "the default",
}
_OF_THE_MODEL = "robot base tip flange ball known distance_deviation zeros gravity"
"""Options that a calibration has of its own."""

POINTS = "points that an instrument measured"

SIZE_LOST, DISTANCE = 0.05, "scale"
"""Standard deviation of the arm's size, as a share, from which a fit gave it up to meet a distance,
and the code of findings on distances."""
NOTHING_WRONG = "Nothing wrong was seen."


class _CheckOptions(cli.RobotOptions, cli.OutputOptions):
    robot: str = cli.option(
        "", "a shipped robot's name, or a URDF file; needed without --calibration", "R"
    )
    calibration: Path | None = cli.option(
        None,
        "tell what changed since this calibration, as mukca validate does; in place of --robot",
        "CALIBRATION",
        unless=_OF_THE_MODEL,
    )
    stood: str = cli.option(
        "",
        "with --calibration: its placement whose base still stands where it stood",
        "PLACEMENT",
        needs="calibration",
    )
    data: Sequence[Path] = cli.argument("placements", "DATA")
    settings: SolveOptions = cli.part(
        SolveOptions,
        "distance known distance_deviation zeros payload gravity repeatability_mm flange_poses "
        "as_recorded leave_out",
    )


def run_check(options: _CheckOptions, terminal: cli.Terminal) -> int:
    """Print one line for each thing seen, and which placement to record next."""
    options.check_out()
    if options.calibration is not None:
        names = [field.name for field in fields(ValidateOptions)]
        same = {
            name: getattr(options, name) for name in names if hasattr(options, name)
        }
        return run_validate(ValidateOptions(**same), terminal)
    if not options.robot:
        raise UsageError(
            "--robot R: whose recordings? Or --calibration: what changed since it"
        )
    robot = options.load_robot()
    settings = options.settings.validated()
    placements_read = recorder.read_placements(
        *options.data, as_recorded=settings.as_recorded
    )
    # as solve begins, all placements trained on
    problem = calibration.problems_of(robot, placements_read, (), settings)[""]
    placements = problem.measurements
    survey = problem.survey
    terminal.warn(*problem.warnings)
    findings, accuracy = _by_a_fit(problem, settings)
    of_one = set(
        chain.from_iterable(inspection.diagnostics for inspection in survey.placements)
    )
    shared = [finding for finding in findings if finding not in of_one]
    broken = _are_broken(findings)
    predicted = None if accuracy is None else accuracy.distance_deviation
    scale = None if accuracy is None else accuracy.scale
    hint = diagnostics.next_placement(robot, survey)
    repeatability = assessment.repeatability_of(robot, settings.repeatability_mm)
    lines = [
        *_seen(survey, shared),
        _amount(placements, accuracy, repeatability, broken=broken),
        hint,
    ]
    in_sockets = [m for m in placements if m.kind == "sockets" and m.has_distance]
    assumed = [m.distance for m in in_sockets if m.distance_source == "default"]
    readings = max((m.distance_readings for m in in_sockets), default=1)
    causes = survey.hypotheses
    tied = bool(settings.distances)
    recordings = assessment.Recordings(
        placements,
        (),
        scale,
        assumed=assumed,
        readings=readings,
        tied=tied,
        causes=causes,
    )
    rows = assessment.recording_rows(findings, recordings)
    verdict = assessment.judge(rows, survey.hypotheses)
    answer = f"{verdict.title}: {verdict.text}"
    if verdict.status == "pass":
        remarks = assessment.plural(len(findings), "remark")
        answer = (
            f"Nothing bars a calibration; {remarks}." if findings else NOTHING_WRONG
        )
    lines.insert(0, answer)
    terminal.say(*lines)
    emit_with_page(
        options,
        terminal,
        lines,
        {
            "robot": options.robot,
            "findings": [finding.as_dict() for finding in shared],
            "placements": [_row(inspection) for inspection in survey.placements],
            "hypotheses": [asdict(hypothesis) for hypothesis in survey.hypotheses],
            "scale": None if scale is None else scale.as_dict(),
            "predicted_distance_deviation": predicted,
            "next_placement": {"text": hint},
            "warnings": list(problem.warnings),
            "verdict": verdict.as_said(),
        },
    )
    return verdict.exit_status


def _are_broken(findings: "Sequence[results.Diagnostic]") -> bool:
    return any(finding.level == "error" for finding in findings)


def _by_a_fit(
    problem: "calibration.CalibrationProblem", settings: SolveOptions
) -> "tuple[tuple[results.Diagnostic, ...], design.Accuracy | None]":
    """Return what was seen, and the accuracy by a fit; None where something bars it.

    A distance is an error where the fit gave the arm's size up to meet it.
    """
    findings = problem.checks
    if _are_broken(findings):
        return findings, None
    premises = settings.load, settings.distances, settings.deviation
    zeros = bool(settings.zeros)
    accuracy = design.accuracy_by(
        problem.robot, problem.measurements, *premises, zeros=zeros
    )
    if accuracy is None or (accuracy.scale.deviation or 0.0) <= SIZE_LOST:
        return findings, accuracy
    judged = tuple(
        replace(finding, level="error") if finding.code == DISTANCE else finding
        for finding in findings
    )
    return judged, None if _are_broken(judged) else accuracy


def _row(inspection: "diagnostics.Inspection") -> dict[str, Any]:
    return {
        "name": inspection.measured.name,
        "samples": list(inspection.measured.counts),
        "distance": inspection.measured.distance
        if inspection.measured.has_distance
        else None,
        "distance_source": inspection.measured.distance_source,
        "floor": inspection.floor,
        "findings": [finding.as_dict() for finding in inspection.diagnostics],
    }


def _seen(
    survey: "diagnostics.Survey", shared: "Sequence[results.Diagnostic]"
) -> list[str]:
    lines = [f"{finding.level}: {finding}" for finding in shared]
    for inspection in survey.placements:
        measured = inspection.measured
        counts = "+".join(map(str, measured.counts))
        samples = "samples" if measured.kind == "sockets" else POINTS
        distance = (
            f"; sockets {1e3 * measured.distance:g} mm apart ({_SOURCES[measured.distance_source]})"
            if measured.has_distance
            else ""
        )
        lines.append(
            f"{measured.name}: {counts} {samples}{distance}; fitted alone it leaves "
            f"{1e3 * inspection.floor:.3f} mm"
        )
        lines += [f"  {finding.level}: {finding}" for finding in inspection.diagnostics]
    return lines


def _amount(
    placements: "Sequence[data.Measurement]",
    accuracy: "design.Accuracy | None",
    repeatability: float | None,
    *,
    broken: bool,
) -> str:
    """Return the number of samples, and the accuracy of a calibration on them."""
    total = sum(sum(measured.counts) for measured in placements)
    count = assessment.plural(len(placements), "placement")
    text = f"In all {total} samples in {count}"
    if accuracy is not None:
        predicted, _, length = accuracy
        words = assessment.predicted_in_words(predicted, length, repeatability)
        return f"{text}: calibrated on them, {words}."
    why = "mend the errors first" if broken else "a fit to them does not settle"
    return f"{text}; what a calibration would know by them cannot be told: {why}."

"""``mukca check``: look at recordings before they are fitted."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....solver.calibration import SolveOptions
from .. import JsonOption, RobotOptions, Terminal, argument, measure_all, part

if TYPE_CHECKING:
    from ....solver.data import Measurement
    from ....solver.diagnostics import Diagnostic, Inspection, Survey

_SOURCES = {"given": "as given", "recording": "by the recording", "default": "the default"}


POINTS_HINT = (
    "Measured points need no socket: spread the next ones over the workspace, and hold some out."
)


@dataclass(frozen=True, kw_only=True)
class Options(RobotOptions, JsonOption):
    """Options of ``mukca check``."""

    data: Sequence[Path] = argument("placements", "DATA")
    settings: SolveOptions = part(
        SolveOptions,
        "distance",
        "known",
        "distance_deviation",
        "zeros",
        "payload",
        "gravity",
        "repeatability_mm",
    )


def run(options: Options, terminal: Terminal) -> int:
    """Print one line for each thing seen, and which placement to record next."""
    from ....solver.assessment import checks_row, distance_row, judge, repeatability_of
    from ....solver.data import check_distinct
    from ....solver.design import predicted_error
    from ....solver.diagnostics import (
        cause,
        inspect_all,
        next_placement,
        single_socket_diagnostics,
    )

    robot, settings = options.load_robot(), options.settings.validated()
    data = measure_all(options.data, robot, settings.distance, sockets=1)
    check_distinct(data)
    warnings = [line for measured in data for line in measured.warnings]
    terminal.warn(*warnings)
    known, deviation = settings.distances, settings.deviation
    zeros = bool(settings.zeros)
    survey = inspect_all(
        robot,
        data,
        known=known,
        deviation=deviation,
        zeros=zeros,
        repeatability=repeatability_of(robot, settings.repeatability_mm),
    )
    lone = single_socket_diagnostics(data, known)
    shared, findings = (*survey.shared, *lone), (*survey.diagnostics, *lone)
    broken = any(finding.level == "error" for finding in findings)
    predicted = None
    if not broken:
        predicted = predicted_error(robot, data, settings.load, known, deviation, zeros=zeros)
    hint = next_placement(robot, survey) if survey.placements else POINTS_HINT
    points = [
        f"{m.name}: {sum(m.counts)} points that an instrument measured"
        for m in data
        if m.kind == "points"
    ]
    terminal.say(*_seen(survey, shared), *points, _amount(data, predicted, broken=broken), hint)
    verdict = judge([checks_row(findings), distance_row(_assumed(data))])
    if cause(survey.hypotheses):
        terminal.say(f"Of all recordings, {cause(survey.hypotheses)}.")
    if verdict.status == "incomplete":
        terminal.say(f"{verdict.title}: {verdict.text}")
    elif not findings:
        terminal.say("Nothing wrong was seen.")
    terminal.emit(
        {
            "robot": options.robot,
            "findings": [finding.as_dict() for finding in shared],
            "placements": [_row(one) for one in survey.placements],
            "hypotheses": [asdict(one) for one in survey.hypotheses],
            "scale": None if survey.scale is None else asdict(survey.scale),
            "predicted_distance_deviation": predicted,
            "next_placement": {"text": hint},
            "warnings": warnings,
            "verdict": {"status": verdict.status, "kind": verdict.kind, "text": verdict.text},
        }
    )
    return verdict.exit_status


def _assumed(data: "Sequence[Measurement]") -> list[float]:
    """Return the distances that neither a person nor a recording said [m]."""
    seated = [m for m in data if m.kind == "sockets" and m.has_distance]
    return [m.distance for m in seated if m.distance_source == "default"]


def _row(one: "Inspection") -> dict[str, Any]:
    """Return what one placement shows, for JSON."""
    return {
        "name": one.measured.name,
        "samples": list(one.measured.counts),
        "distance": one.measured.distance if one.measured.has_distance else None,
        "distance_source": one.measured.distance_source,
        "floor": one.floor,
        "findings": [finding.as_dict() for finding in one.diagnostics],
    }


def _seen(survey: "Survey", shared: "Sequence[Diagnostic]") -> list[str]:
    """Return what was seen, a line each."""
    lines = [f"{finding.level}: {finding}" for finding in shared]
    for one in survey.placements:
        measured = one.measured
        counts = "+".join(map(str, measured.counts))
        distance = (
            f"; sockets {1e3 * measured.distance:g} mm apart ({_SOURCES[measured.distance_source]})"
            if measured.has_distance
            else ""
        )
        lines.append(
            f"{measured.name}: {counts} samples{distance}; fitted alone it leaves "
            f"{1e3 * one.floor:.3f} mm"
        )
        lines += [f"  {finding.level}: {finding}" for finding in one.diagnostics]
    return lines


def _amount(data: "Sequence[Measurement]", predicted: float | None, *, broken: bool) -> str:
    """Return how much there is, and what a calibration would know by it."""
    total = sum(sum(measured.counts) for measured in data)
    places = f"{len(data)} placement{'s' * (len(data) > 1)}"
    text = f"In all {total} samples in {places}"
    if predicted is not None:
        return (
            f"{text}: calibrated on them, distances in the workspace would be known to "
            f"{1e3 * predicted:.2f} mm (1 sigma, median)."
        )
    why = "mend the errors first" if broken else "a fit to them does not settle"
    return f"{text}; what a calibration would know by them cannot be told: {why}."

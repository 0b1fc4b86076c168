"""``mukca check``: recordings by themselves."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

from .... import recorder
from ....solver import assessment, calibration, design, diagnostics, results
from ....solver.calibration import SolveOptions, UsageError
from ... import cli
from .report import emit_with_page
from .validate import ValidateOptions, run_validate

_SOURCES = {
    "given": "as given",
    "recording": "by the recording",
    "default": "the default",
}
POINTS = "points that an instrument measured"

SIZE_LOST = 0.05
"""Standard deviation of the arm's size, as a share, from which a fit gave it up for a distance."""
DISTANCE = "scale"
"""Code of findings on distances."""
TESTED = (
    "Solve fits more unknowns, and tests its fit: its figure may be half or twice this."
)
"""Said of the accuracy by a fit that nothing was left out of."""
ALONE = "One place proves nothing about others: for PASS record another."
"""Said beside it of a single placement, which leaves nothing to hold out."""
NOTHING_WRONG = "Nothing wrong was seen."


class _CheckOptions(cli.RobotOptions, cli.TableOptions, cli.OutputOptions):
    robot: str = ""
    calibration: Path | None = None
    stood: str = ""
    data: Sequence[Path]
    settings: SolveOptions = cli.part(
        SolveOptions,
        "distance known distance_deviation zeros payload gravity repeatability_mm flange_poses "
        "as_recorded leave_out",
    )


@dataclass(frozen=True)
class _Checked:
    """Recordings that were looked at, and the accuracy of a calibration on them."""

    problem: "calibration.InspectedProblem"
    """As solve begins, all placements trained on."""
    findings: "Sequence[results.Diagnostic]"
    accuracy: "design.Accuracy | None"
    """None where an error bars a fit, or none settles."""

    @property
    def survey(self) -> "diagnostics.Survey":
        return self.problem.survey

    @cached_property
    def shared(self) -> "list[results.Diagnostic]":
        """Findings that are not told with their placement."""
        inspections = self.survey.placements
        of_one = set(chain.from_iterable(one.diagnostics for one in inspections))
        return [finding for finding in self.findings if finding not in of_one]

    @cached_property
    def next_placement(self) -> str:
        return diagnostics.next_placement(self.problem.robot, self.survey)

    @cached_property
    def verdict(self) -> "assessment.Verdict":
        """The verdict on recordings, by the rows that a calibration has, too."""
        placements = self.problem.measurements
        in_sockets = [m for m in placements if m.kind == "sockets" and m.has_distance]
        accuracy = self.accuracy
        recordings = assessment.Recordings(
            placements,
            (),
            accuracy and accuracy.scale,
            assumed=[m.distance for m in in_sockets if m.distance_source == "default"],
            readings=max((m.distance_readings for m in in_sockets), default=1),
            tied=bool(self.problem.options.distances),
            causes=self.survey.hypotheses,
            better=accuracy and accuracy.better,
        )
        rows = assessment.recording_rows(self.findings, recordings, recordings.better)
        return assessment.judge(rows, self.survey.hypotheses)

    @property
    def answer(self) -> str:
        """The verdict in a line; without one that bars a fit, the number of remarks."""
        verdict = self.verdict
        if verdict.status != "pass":
            return f"{verdict.title}: {verdict.text}"
        count = len(self.findings) + len(self.problem.warnings)
        answer = NOTHING_WRONG
        if count:
            answer = f"No error was seen; {assessment.plural(count, 'remark')}."
        better = self.accuracy and self.accuracy.better
        doubts = [row.text for row in verdict.reasons if row.name == "samples"]
        if better and better.probability < assessment.SURE:
            odds = assessment.in_100(better.probability)
            doubts.append(f"a calibration is better with a chance of {odds} only")
        return " ".join([answer, *(f"{text[0].upper()}{text[1:]}." for text in doubts)])

    @cached_property
    def lines(self) -> list[str]:
        """All that the terminal says."""
        seen = _seen(self.survey, self.shared)
        return [self.answer, *seen, self.amount, self.next_placement]

    @property
    def amount(self) -> str:
        """Number of samples, and the accuracy of a calibration on them."""
        problem, accuracy = self.problem, self.accuracy
        total = sum(sum(measured.counts) for measured in problem.measurements)
        count = assessment.plural(len(problem.measurements), "placement")
        text = f"In all {total} samples in {count}"
        if accuracy:
            repeatability = assessment.repeatability_of(
                problem.robot, problem.options.repeatability_mm
            )
            now = accuracy.better.workspace.now
            words = assessment.predicted_in_words(now, accuracy.length, repeatability)
            alone = (
                ALONE if [m.kind for _, m in problem.placements] == ["sockets"] else ""
            )
            return f"{text}. By a quick fit, {words}. {TESTED} {alone}".rstrip()
        why = "a fit to them does not settle"
        if _are_broken(self.findings):
            why = "correct the errors first"
        return f"{text}; how well they calibrate the arm is not known: {why}."

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        accuracy, survey = self.accuracy, self.survey
        return {
            "findings": [finding.as_dict() for finding in self.shared],
            "placements": [_row(inspection) for inspection in survey.placements],
            "hypotheses": [asdict(hypothesis) for hypothesis in survey.hypotheses],
            "scale": accuracy and accuracy.scale.as_dict(),
            "predicted_distance_deviation": accuracy and accuracy.distance_deviation,
            "better": accuracy and accuracy.better.as_dict(),
            "next_placement": {"text": self.next_placement},
            "warnings": list(self.problem.warnings),
            "verdict": self.verdict.as_said(),
        }


def run_check(options: _CheckOptions, terminal: cli.Terminal) -> int:
    """Print one line for each thing seen, and which placement to record next."""
    options.check_out()
    if options.calibration:
        names = {field.name for field in fields(ValidateOptions)} & set(vars(options))
        same = {name: getattr(options, name) for name in names}
        return run_validate(ValidateOptions(**same), terminal)
    if not options.robot:
        raise UsageError(
            "--robot R: whose recordings? Or --calibration: what changed since it"
        )
    robot = options.load_robot()
    settings = options.settings.validated()
    placements = recorder.read_placements(
        *options.data, as_recorded=settings.as_recorded, **options.table
    )
    problem = calibration.problem_in_any_reach(robot, placements, settings)
    assert isinstance(problem, calibration.InspectedProblem)
    checked = _checked(problem)
    terminal.warn(*checked.problem.warnings)
    terminal.say(*checked.lines)
    document = {"robot": options.robot, **checked.as_dict()}
    emit_with_page(options, terminal, checked.lines, document)
    return checked.verdict.exit_status


def _are_broken(findings: "Sequence[results.Diagnostic]") -> bool:
    return any(finding.level == "error" for finding in findings)


def _checked(problem: "calibration.InspectedProblem") -> _Checked:
    """Return what was seen, and the accuracy by a fit; None where something bars it.

    A distance is an error where no fit settles by it, or gave the arm's size up to meet it.
    """
    if _are_broken(problem.checks):
        return _Checked(problem, problem.checks, None)
    settings = problem.options
    accuracy = design.accuracy_by(
        problem.robot,
        problem.measurements,
        settings.load,
        settings.distances,
        settings.deviation,
        zeros=bool(settings.zeros),
    )
    if accuracy and not accuracy.distorted:
        problem = problem.sized(accuracy.scale)
        if (accuracy.scale.deviation or 0.0) <= SIZE_LOST:
            return _Checked(problem, problem.checks, accuracy)
    judged = [
        replace(finding, level="error") if finding.code == DISTANCE else finding
        for finding in problem.checks
    ]
    return _Checked(problem, judged, None if _are_broken(judged) else accuracy)


def _row(inspection: "diagnostics.Inspection") -> dict[str, Any]:
    measured = inspection.measured
    return {
        "name": measured.name,
        "samples": list(measured.counts),
        "distance": measured.distance if measured.has_distance else None,
        "distance_source": measured.distance_source,
        "floor": inspection.floor,
        "findings": [finding.as_dict() for finding in inspection.diagnostics],
    }


def _seen(
    survey: "diagnostics.Survey",
    shared: "Sequence[results.Diagnostic]",
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
            f"{measured.name}: {counts} {samples}{distance}; a fit to it alone is off "
            f"by {1e3 * inspection.floor:.3f} mm"
        )
        lines += [f"  {finding.level}: {finding}" for finding in inspection.diagnostics]
    return lines

"""Steps to do where the verdict is not PASS, the most useful first, each with a command."""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import cast

import numpy as np

from ....errors import MukcaError
from ....solver.assessment import (
    Assessment,
    PlacementReport,
    area,
    joined,
    joints_wrong,
    mm,
)
from ....solver.diagnostics import farthest_place
from ....solver.identification.data import (
    CALIPER_DEVIATION,
    DEFAULT_DISTANCE,
    SAMPLES_ADVISED,
    Measurement,
    as_point,
    evaluate,
)
from ....solver.identification.paper import build_problem, solve
from ....solver.results import CalibrationDocument, Role
from .answers import farthest_held_out, placements_with_errors
from .command_lines import as_options, one_robot, record_command, solve_command
from .recorded_already import UnusedPlacement, unused_placements
from .types import Step

_SPAN = 0.5
"""A distance in the workspace [m]."""
BESIDE = 0.2
"""A place is no new one if it is nearer to a placement than this [m]."""


def steps(result: Assessment) -> list[Step]:
    """Return the next step for a calibration; none where the verdict is PASS."""
    return list(islice(_steps(result), 1))


def _steps(result: Assessment) -> Iterator[Step]:
    """Yield steps, the most useful first."""
    verdict = result.verdict
    placements = result.placements
    if verdict.status == "pass":
        return
    document = result.predictions.document
    status = verdict.status_of
    if status("data_checks") != "pass":
        yield from _mend(result)
    if {status("scale"), status("distance_given")} != {"pass"}:
        yield from _measure(document, placements)
    is_proved = any(row.role != "train" for row in placements)
    unused = unused_placements(result)
    rows = (*verdict.limits, *verdict.reasons)
    missed = any(row.status in ("fail", "not enough") for row in rows)
    is_lacking = is_proved and (missed or not verdict.use)
    if not is_proved:
        yield from _leave_each_out(document, unused)
    if is_lacking:
        yield from _train_on_held_out(result)
    yield from _corrected_joints(result)
    if is_lacking and unused:
        yield _train_on_unused(document, unused[0])
    by_instrument = all(row.kind == "points" for row in placements)
    is_usable = by_instrument or (is_proved and bool(verdict.use))
    if result.limits.repeatability is None and is_usable:
        yield _repeatability(document)
    if by_instrument:
        text = "Measure more points, in poses as varied as can be"
        yield Step(text, solve_command(document), "")
        return
    text = f"Record another placement {_place_in_words(result)}, all varied, {SAMPLES_ADVISED}"
    if document.arms is not None:
        text += ", with each of the arms, into folders of one name"
    text += ", and train on it too"
    if not is_proved:
        text += ": each place is then left out once, which proves the fit"
    yield _forecast(document, None, text, record_command(document))


def _mend(result: Assessment) -> Iterator[Step]:
    """Yield the steps to leave out what is wrong in the recordings, or to look at it."""
    document = result.predictions.document
    yield from _leave_out(result)
    text = "See what is wrong in the recordings; mend it, or leave it out by solve --leave-out"
    folders = list(dict.fromkeys(row.folder for row in document.data))
    keys = ("distance", "known", "zeros")
    same = as_options({key: document.settings.get(key) for key in keys})
    command = shlex.join(["mukca", "check", *folders, *one_robot(document), *same])
    yield Step(text, command, "figures that can be believed")


def _train_on_held_out(result: Assessment) -> Iterator[Step]:
    """Yield the step to train on one of several held-out placements too, where any is sound."""
    document = result.predictions.document
    several = sum(row.role == "test" for row in result.placements) > 1
    farthest = farthest_held_out(result) if several else None
    if farthest is None:
        return
    index, gap = farthest
    name = result.placements[index].name
    short = result.predictions.names[index]
    text = f"Train on {short} too: recorded already, {gap:.2f} m from the nearest trained on"
    command = solve_command(document, moves={name: "train"})
    yield _forecast(document, name, text, command)


def _train_on_unused(document: CalibrationDocument, unused: UnusedPlacement) -> Step:
    """Return the step to train on a placement that the calibration did not use."""
    text = f"Train on {unused.name} too: it lies beside the others, {unused.gap:.2f} m from the "
    text += "nearest trained on"
    command = solve_command(document, added={unused.folder: "train"})
    return Step(text, command, "a smaller error, since more places are known")


def _leave_each_out(
    document: CalibrationDocument, unused: Sequence[UnusedPlacement]
) -> Iterator[Step]:
    """Yield the steps that prove a fit by what is recorded already, where nothing was left out."""
    words = "each place is left out once, which proves the fit: errors, and a verdict"
    if document.settings.get("no_proof"):
        command = solve_command(document, settings_given={"no_proof": False})
        yield Step("Leave each place out once: drop --no-proof", command, words)
    elif unused:
        names = joined([placement.name for placement in unused])
        text = f"Train on {names} too, recorded already beside the others"
        added: dict[str, Role] = {placement.folder: "train" for placement in unused}
        yield Step(text, solve_command(document, added=added), words)


def _place_in_words(result: Assessment) -> str:
    """Return where another placement serves best: as far from all others as can be.

    Several arms look at one place from two sides, so no side is named.
    """
    places = np.array([row.position for row in result.placements])
    place = farthest_place(places)
    gap = float(np.linalg.norm(places - place, axis=1).min())
    if gap < BESIDE:
        return "higher or lower than the others, which lie all round"
    if result.predictions.document.arms is not None:
        return "far from the others"
    return f"about {area(as_point(place))}, {gap:.2f} m from the others"


def _corrected_joints(result: Assessment) -> Iterator[Step]:
    """Yield the step to correct joint positions, where the full model keeps all limits."""
    verdict = result.verdict
    missed = [row for row in verdict.limits if row.status in ("fail", "not enough")]
    if (
        not verdict.use
        or not missed
        or any(row.full_status != "pass" for row in missed)
    ):
        return
    first = missed[0]
    before = cast("float", first.found)
    after = cast("float", first.full)
    text = "Command corrected joint positions where the limits matter; no rigid URDF keeps them"
    words = f"{first.title}: {mm(after, 3)} in place of {mm(before, 3)}"
    file = result.predictions.document.outputs.get("calibration")
    folder = "DIR" if file is None else str(Path(file).parent)
    command = shlex.join(
        ["mukca", "command", folder, "poses.csv", "--out", "joints.csv"]
    )
    yield Step(text, command, words, before, after)


def _repeatability(document: CalibrationDocument) -> Step:
    """Return the step that says how well the arm repeats, without which there are no limits."""
    text = "Say how well the arm repeats, from its data sheet"
    command_line = solve_command(document, settings_given={"repeatability_mm": "MM"})
    return Step(
        text, command_line, "limits to hold the errors against, not a smaller error"
    )


def _measure(
    document: CalibrationDocument, placements: Sequence[PlacementReport]
) -> Iterator[Step]:
    """Yield the step to measure the sockets' distance, unless joints come before it."""
    scale = document.scale
    if not any(row.distance for row in placements) or joints_wrong(document.checks):
        return
    text = "Measure the sockets' distance, and type what you read"
    command = solve_command(document, settings_given={"distance": "MEASURED"})
    if scale is None:
        yield Step(text, command, "an arm of the right size")
        return
    deviation = scale.deviation or CALIPER_DEVIATION / DEFAULT_DISTANCE
    before = abs(scale.value) * _SPAN
    after = deviation * _SPAN
    words = f"a distance of {_SPAN:g} m is known to {mm(after)}"
    if before > after:
        words = (
            f"if it was wrong, the error of a distance of {_SPAN:g} m falls from {mm(before)} to "
            f"{mm(after)}; if you read the same, a length of the model is wrong"
        )
    yield Step(text, command, words, before, after)


def _forecast(
    document: CalibrationDocument, name: str | None, text: str, command: str
) -> Step:
    """Return a step with what the posterior forecasts of it, where it does."""
    rows = () if document.outlook is None else document.outlook.forecasts
    forecasts = {row.placement: row.distance_deviation for row in rows}
    if document.uncertainty is None or name not in forecasts:
        why = "only --method auto makes one"
        if document.method == "auto":
            why = "none of the places that were tried for it is within the arm's reach"
        return Step(text, command, f"no forecast: {why}")
    accuracy = document.uncertainty.distance_deviation
    before = accuracy.median
    after = forecasts[name]
    # several arms have a workspace each
    workspace = f" in {document.arm_name}'s own workspace" if document.arm_name else ""
    falls = f"falls from {mm(before)} to {mm(after)}"
    words = f"the predicted error of distances{workspace}, trained on it too, {falls}"
    return Step(text, command, words, before, after)


def _leave_out(result: Assessment) -> Iterator[Step]:
    """Yield the step to leave out placements with errors, with what Eq. (5) expects of it."""
    predictions = result.predictions
    bad = placements_with_errors(result)
    faulty = {result.placements[i].name for i in bad}
    paired = [p for p in predictions.placements if p.measured.has_distance]
    training = [p.measured for p in paired if p.role == "train"]
    remaining = [m for m in training if m.name not in faulty]
    judges = [p.measured for p in paired if p.role == "test" and p.name not in faulty]
    if not remaining or not judges or len(remaining) == len(training):
        return

    def held_out(train: Sequence[Measurement]) -> float:
        problem = build_problem(predictions.robot, train)
        x = solve(problem).x
        errors = (evaluate(problem.model.points(x, m.positions), m) for m in judges)
        return sum(error.mean_absolute_error for error in errors) / len(judges)

    with suppress(MukcaError):
        before = held_out(training)
        after = held_out(remaining)
        text = f"Leave out {joined([result.predictions.names[i] for i in bad])}"
        command = solve_command(
            predictions.document, moves=dict.fromkeys(sorted(faulty))
        )
        words = (
            f"the held-out error by Eq. (5) goes from {mm(before, 3)} to {mm(after, 3)}"
        )
        yield Step(text, command, words, before, after)

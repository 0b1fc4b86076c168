"""Steps by what is recorded: leave a placement out, record it again, look, or use another."""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....errors import MukcaError
from ....recorder import RecordingError, find_placements, read_placement
from ....solver.assessment import (
    LEAST_HELD_OUT,
    MOVEMENTS,
    Assessment,
    drifts_of,
    joined,
    mm,
)
from ....solver.identification.data import NEAREST, Measurement, evaluate, measure
from ....solver.identification.paper import build_problem, solve
from ....solver.tables import parse_left_out
from .answers import placements_named, placements_with_errors
from .command_lines import as_options, one_robot, record_command, solve_command
from .types import Step

BELIEVED = "figures that can be believed"


def mending_steps(result: Assessment) -> Iterator[Step]:
    """Yield the steps to leave out what is wrong in the recordings, to record it again, to look.

    A placement is contradicted as long as it is trained on, so no other step stands beside these.
    """
    document = result.predictions.document
    yield from _leave_out(result)
    bad = placements_with_errors(result)
    if len(bad) < len(result.placements) or len(bad) == 1:
        yield from _record_again(result, bad)
    errors = [check for check in document.checks or () if check.level == "error"]
    text = "See what is wrong in the recordings"
    text += f": {errors[0].advice}" if errors and errors[0].advice else ""
    folders = dict.fromkeys(row.folder for row in document.data)
    keys = ("distance", "known", "zeros")
    same = as_options({key: document.settings.get(key) for key in keys})
    command = shlex.join(["mukca", "check", *folders, *one_robot(document), *same])
    yield Step(text, command, BELIEVED)


def steps_where_something_moved(result: Assessment) -> Iterator[Step]:
    """Yield the step to record placements again that were trained on though something moved."""
    checks = result.predictions.document.checks or ()
    moved = [check for check in checks if check.code in MOVEMENTS]
    named = placements_named(result, moved)
    if result.verdict.status_of("drift") == "not enough":
        drifts = drifts_of(result.predictions, "train")
        named = [i for i, row in enumerate(result.placements) if row.name in drifts]
    trained = [i for i in named if result.placements[i].role != "test"]
    yield from _record_again(result, trained)


def _record_again(result: Assessment, bad: Sequence[int]) -> Iterator[Step]:
    """Yield the step to record placements again that are contradicted, if any."""
    if bad:
        names = joined([result.predictions.names[i] for i in bad])
        text = f"Record {names} again, and solve with it in place of the first"
        yield Step(text, record_command(result.predictions.document), BELIEVED)


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


class UnusedPlacement(NamedTuple):
    """A placement that a calibration did not use, though it lies beside its recordings."""

    folder: str
    gap: float
    """Distance from the nearest place that was trained on [m]."""

    @property
    def name(self) -> str:
        """Name of its folder."""
        return Path(self.folder).name


def unused_placements(result: Assessment) -> list[UnusedPlacement]:
    """Return the unused placements, that farthest from those trained on first.

    Several arms share their recordings' folders, so nothing is looked for there.
    """
    if result.predictions.document.arms:
        return []
    return sorted(_unused(result), key=lambda placement: -placement.gap)


def _unused(result: Assessment) -> Iterator[UnusedPlacement]:
    """Yield the placements of this robot's joints beside the recordings that were not used."""
    predictions = result.predictions
    rows = [row for row in predictions.document.data if row.files]
    used = {Path(row.folder).resolve() for row in rows}
    places = np.array([p.position for p in predictions.of_role("train")])
    for parent in dict.fromkeys(Path(row.folder).parent for row in rows):
        folders: list[Path] = []
        with suppress(RecordingError):  # on another computer, they are not there
            folders = find_placements([parent])
        for folder in folders:
            place = None if folder.resolve() in used else _place_of(folder, result)
            if place is None:
                continue
            gap = float(np.linalg.norm(places - place, axis=1).min())
            if gap >= NEAREST:
                yield UnusedPlacement(str(folder), gap)


def _place_of(folder: Path, result: Assessment) -> np.ndarray | None:
    """Return the middle of the sockets of a placement [m]; None where it is of no use.

    That is one of another arm, one that the calibration was to leave out, or with few samples.
    """
    calibration = result.predictions.calibration
    document = result.predictions.document
    try:
        placement = read_placement(folder)
        measured = measure(placement, calibration.robot)
    except MukcaError:
        return None
    left_out = map(parse_left_out, document.settings.get("leave_out") or ())
    faulty = any(check.where.startswith(str(folder)) for check in document.checks or ())
    few = not measured.has_distance or min(measured.counts) < LEAST_HELD_OUT
    if faulty or few or any(item.names(placement) for item in left_out):
        return None
    return calibration.ball(measured.positions, measured.efforts).mean(axis=0)

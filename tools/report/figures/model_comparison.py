"""Several calibrations of one robot on the same data: which is better where, beyond the noise."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import combinations
from pathlib import Path

import numpy as np

from ....errors import MukcaError
from ....solver.assessment import measurements_of, quantiles
from ....solver.calibration import Calibration, differences
from ....solver.identification.data import (
    Measurement,
    evaluate,
    kabsch,
    mean_metrics,
    targets,
)
from ....solver.results import Apart, CalibratedRobot, agreement
from .comparison import (
    COMPARISON,
    NOMINAL,
    ComparedModel,
    ComparedPair,
    ComparedPlacement,
    ComparisonDocument,
    Difference,
    ErrorsAtPlacement,
    ErrorsOverall,
)
from .types import Displacement

STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.2)
"""Half the width of a 95 % interval in standard errors, for 1 to 9 degrees of freedom, and more."""


class ComparisonError(MukcaError):
    """Calibrations that cannot be compared."""


def contenders_of(files: Sequence[Path]) -> dict[str, Calibration]:
    """Return the calibrations in some files, by the shortest names that tell their folders apart.

    Those of other joints are a ComparisonError.
    """
    if len(set(files)) < len(files):
        raise ComparisonError("a calibration is named twice; name each only once")
    folders = [file.resolve().parent.parts for file in files]
    tries = [["/".join(parts[-count:]) for parts in folders] for count in (1, 2)]
    tries.append([str(file) for file in files])
    names = next(names for names in tries if len({*names, NOMINAL}) > len(files))
    contenders = dict(zip(names, map(Calibration.of_file, files), strict=True))
    first = next(iter(contenders.values()))
    joints = ", ".join(first.robot.joint_names)
    for contender in contenders.values():
        others = ", ".join(contender.robot.joint_names)
        if others != joints:
            raise ComparisonError(
                f"{contender.source}: its joints are {others}, but those of {first.source} "
                f"are {joints}; only calibrations of one model of robot can be compared"
            )
    return contenders


def shared_data(contenders: Iterable[Calibration]) -> list[Measurement]:
    """Return all placements that the calibrations' files hold, each once."""
    shared: dict[tuple[float, ...], Measurement] = {}
    for contender in contenders:
        for m in measurements_of(contender.document, contender.robot):
            shared.setdefault(tuple(m.placement.positions.ravel().tolist()), m)
    return list(shared.values())


@dataclass(frozen=True)
class _Contest:
    """Models on placements: what each predicts, and how far off it is."""

    contestants: Sequence[Calibration]
    models: Sequence[CalibratedRobot]
    """The nominal model, and those of the contestants."""
    data: Sequence[Measurement]

    @cached_property
    def points(self) -> list[list[np.ndarray]]:
        """Balls at each placement by each model, shape (N, 3) [m]."""
        return [[model.predict(m) for model in self.models] for m in self.data]

    @cached_property
    def errors(self) -> list[list[np.ndarray]]:
        """Lengths of the errors at each placement by each model, shape (N,) [m]."""
        errors: list[list[np.ndarray]] = []
        for points_by_model, m in zip(self.points, self.data, strict=True):
            deviations = [points - targets(points, m) for points in points_by_model]
            errors.append([np.linalg.norm(rows, axis=1) for rows in deviations])
        return errors

    @cached_property
    def placements(self) -> list[ComparedPlacement]:
        """The errors of all models at each placement."""
        rows = zip(self.data, self.points, self.errors, strict=True)
        return [self._placement(*row) for row in rows]

    def _placement(
        self, m: Measurement, points: list[np.ndarray], errors: list[np.ndarray]
    ) -> ComparedPlacement:
        trained_on = [False, *(one.was_trained_on(m) for one in self.contestants)]
        models = tuple(
            ErrorsAtPlacement(
                **asdict(evaluate(balls, m)),
                quantiles=quantiles(lengths),
                trained_on=is_trained,
            )
            for balls, lengths, is_trained in zip(
                points, errors, trained_on, strict=True
            )
        )
        return ComparedPlacement(name=m.name, samples=tuple(m.counts), models=models)

    @cached_property
    def fair(self) -> tuple[int, ...]:
        """Indices of the placements that none of the models was trained on."""
        indices: list[int] = []
        for i, placement in enumerate(self.placements):
            if not any(model.trained_on for model in placement.models):
                indices.append(i)
        return tuple(indices)

    def model(self, k: int, name: str) -> ComparedModel:
        """Return a model with its errors over all placements that are fair."""
        summary = None
        if self.fair:
            lengths = np.concatenate([self.errors[i][k] for i in self.fair])
            mean = mean_metrics([self.placements[i].models[k] for i in self.fair])
            summary = ErrorsOverall.filled(
                quantiles(lengths),
                mean_absolute_error=mean.mean_absolute_error,
                distance_error=mean.distance_error,
            )
        corrected = self.models[k].exported is not None
        return ComparedModel(name=name, summary=summary, corrected_joints=corrected)

    def pair(self, a: int, b: int) -> ComparedPair:
        """Return how model b differs from model a, the nominal model being model 0."""
        rows = [_beyond_noise(lengths[b] - lengths[a]) for lengths in self.errors]
        calibrations = (None, *self.contestants)
        first, second = calibrations[a], calibrations[b]
        workspace: Apart | None = None
        by_chance: tuple[Apart | None, ...] = (None,) * len(self.data)
        if first and second:
            workspace, by_chance = differences(first, second, self.data)
        curves = (one and one.document.curves for one in (first, second))
        A = np.concatenate([points[a] for points in self.points])
        B = np.concatenate([points[b] for points in self.points])
        # A ball in a socket does not show the base frame: its motion means nothing.
        gaps = np.linalg.norm(kabsch(B, A).apply(B) - A, axis=1)
        fair_rows = [rows[i] for i in self.fair]
        return ComparedPair(
            a=a,
            b=b,
            placements=tuple(rows),
            summary=_overall(fair_rows) if fair_rows else None,
            workspace=workspace,
            by_chance=by_chance,
            apart=Displacement(mean=float(gaps.mean()), max=float(gaps.max())),
            curves=agreement(*curves),
        )


def compare(
    contenders: Mapping[str, Calibration],
    data: Sequence[Measurement],
) -> ComparisonDocument:
    """Compare calibrations, and the nominal model of the first of them, on placements.

    The ball of the nominal model is the refitted one, where that calibration keeps it.
    """
    first, *_ = contestants = list(contenders.values())
    nominal = first.ball_refitted or first.calibrated.nominal
    calibrated = [contestant.calibrated for contestant in contestants]
    contest = _Contest(contestants, [nominal, *calibrated], data)
    names = (NOMINAL, *contenders)
    pairs = sorted(combinations(range(len(names)), 2), key=lambda pair: pair[::-1])
    return ComparisonDocument(
        format=COMPARISON,
        robot_name=first.robot.name,
        models=tuple(contest.model(k, name) for k, name in enumerate(names)),
        placements=tuple(contest.placements),
        fair=contest.fair,
        pairs=tuple(contest.pair(*pair) for pair in pairs),
        ball_refitted=first.ball_refitted is not None,
    )


def _beyond_noise(changes: np.ndarray) -> Difference:
    """Return a placement's mean difference beside the noise that its samples leave in it."""
    return _beyond(changes.mean(), 2 * changes.std(ddof=1) / len(changes) ** 0.5)


def _overall(rows: Sequence[Difference]) -> Difference:
    means = np.array([row.mean for row in rows])
    noise = float(np.linalg.norm([row.noise for row in rows])) / len(rows)
    if len(rows) > 1:
        # Errors of one placement go together, so the spread between placements counts where it
        # is larger than the samples alone would give.
        factor = STUDENT[min(len(rows), len(STUDENT) + 1) - 2]
        noise = max(noise, factor * float(means.std(ddof=1)) / len(rows) ** 0.5)
    return _beyond(means.mean(), noise)


def _beyond(mean: float, noise: float) -> Difference:
    beyond_noise = bool(abs(mean) > noise)
    return Difference(mean=float(mean), noise=float(noise), beyond_noise=beyond_noise)

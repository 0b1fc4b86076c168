"""Several calibrations of one robot on the same data: which is better where, beyond the noise."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ....errors import MukcaError
from ....solver.assessment import calibrated_points, measurements_of, mm, norms, plural, quantiles
from ....solver.data import Measurement, evaluate, kabsch, mean_metrics, socket_centres
from ....solver.results import (
    CalibratedRobot,
    CalibrationDocument,
    calibrated_robot,
    fields_of,
    read_calibration,
)
from .types import (
    COMPARISON,
    ComparedModel,
    ComparedPair,
    ComparedPlacement,
    ComparisonDocument,
    Difference,
    ErrorsAtPlacement,
    ErrorsOverall,
)
from .types_drawing import Displacement

NOMINAL = "nominal"
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26)
"""Half the width of a 95 % interval in standard errors, for 1 to 9 degrees of freedom."""
MANY = 2.2
"""Likewise for more."""


class ComparisonError(MukcaError):
    """Calibrations that cannot be compared."""


@dataclass(frozen=True)
class Contender:
    """A calibration in the comparison."""

    name: str
    file: Path
    document: CalibrationDocument
    calibration: CalibratedRobot

    def trained_on(self, measured: Measurement) -> bool:
        """Return True where it was fitted to these very samples, wherever they lie now."""
        positions = [sample.position for sample in measured.placement.samples]
        return any(
            row.role == "train" and [sample.position for sample in row.samples] == positions
            for row in self.document.data
        )


@dataclass(frozen=True)
class _PlacementPoints:
    """One placement, and where every model puts the ball in its samples."""

    measured: Measurement
    points: tuple[np.ndarray, ...]
    """Of each model, shape (N, 3) [m]."""
    trained: tuple[bool, ...]
    """True for each model that was fitted to this placement."""

    @property
    def errors(self) -> list[np.ndarray]:
        """The distance of each sample from its socket's mean by each model, shape (N,) [m]."""
        return [self._errors(points) for points in self.points]

    def _errors(self, points: np.ndarray) -> np.ndarray:
        centres = socket_centres(points, self.measured)
        return norms(points - np.repeat(centres, self.measured.counts, axis=0))


def contenders_of(files: Sequence[Path]) -> list[Contender]:
    """Return the calibrations in some files, named by their folders.

    Raises:
        DocumentError: A file is no calibration.
        ComparisonError: They are not of the same joints.
    """
    contenders: list[Contender] = []
    for file, name in zip(files, _names(files), strict=True):
        document = read_calibration(file)
        contenders.append(Contender(name, file, document, calibrated_robot(document, str(file))))
    first = contenders[0].calibration.robot
    for other in contenders:
        joints = other.calibration.robot.joint_names
        if joints != first.joint_names:
            raise ComparisonError(
                f"{other.file}: its joints are {', '.join(joints)}, but those of {files[0]} are "
                f"{', '.join(first.joint_names)}; only calibrations of one robot can be compared"
            )
    return contenders


def _names(files: Sequence[Path]) -> list[str]:
    """Return the shortest names that tell files apart: folder, folders, path."""
    for count in (1, 2):
        names = ["/".join(file.resolve().parent.parts[-count:]) for file in files]
        if len({*names, NOMINAL}) == len(names) + 1:
            return names
    if len(set(files)) < len(files):
        raise ComparisonError("a calibration is named twice; name each only once")
    return [str(file) for file in files]


def shared_data(contenders: Sequence[Contender]) -> list[Measurement]:
    """Return all placements that the calibrations' files hold, each once.

    Raises:
        DocumentError, MeasurementError: A file's samples are damaged.
    """
    robot = contenders[0].calibration.robot
    shared: list[Measurement] = []
    for contender in contenders:
        earlier = [m.placement.positions for m in shared]
        shared += [
            m
            for m in measurements_of(contender.document, robot, str(contender.file))
            if not any(np.array_equal(m.placement.positions, positions) for positions in earlier)
        ]
    return shared


def compare(contenders: Sequence[Contender], data: Sequence[Measurement]) -> ComparisonDocument:
    """Return the comparison.

    Args:
        contenders: At least one; the nominal model of the first is compared as well.
        data: What to compare them on.
    """
    names = [NOMINAL, *(contender.name for contender in contenders)]
    first = contenders[0].calibration
    tried = [
        _PlacementPoints(
            m,
            (
                first.nominal_ball(m.positions),
                *(calibrated_points(c.calibration, m) for c in contenders),
            ),
            (False, *(c.trained_on(m) for c in contenders)),
        )
        for m in data
    ]
    fair = [i for i, placement in enumerate(tried) if not any(placement.trained)]
    judged = [tried[i] for i in fair]
    return ComparisonDocument(
        format=COMPARISON,
        robot_name=first.robot.name,
        models=tuple(
            ComparedModel(name=name, summary=_overall(k, judged) if judged else None)
            for k, name in enumerate(names)
        ),
        placements=tuple(map(_placement, tried)),
        fair=tuple(fair),
        pairs=tuple(_pair(tried, fair, a, b) for b in range(1, len(names)) for a in range(b)),
    )


def _overall(k: int, judged: Sequence[_PlacementPoints]) -> ErrorsOverall:
    """Return the errors of model k over the placements that none was trained on."""
    metrics = [evaluate(placement.points[k], placement.measured) for placement in judged]
    return ErrorsOverall(
        mean_absolute_error=float(np.mean([m.mean_absolute_error for m in metrics])),
        distance_error=mean_metrics(metrics).distance_error,
        **fields_of(quantiles(np.concatenate([placement.errors[k] for placement in judged]))),
    )


def _placement(tried: _PlacementPoints) -> ComparedPlacement:
    return ComparedPlacement(
        name=tried.measured.name,
        samples=tuple(tried.measured.counts),
        models=tuple(
            ErrorsAtPlacement(
                **asdict(evaluate(points, tried.measured)),
                quantiles=quantiles(errors),
                trained_on=trained,
            )
            for points, errors, trained in zip(
                tried.points, tried.errors, tried.trained, strict=True
            )
        ),
    )


def _pair(tried: Sequence[_PlacementPoints], fair: Sequence[int], a: int, b: int) -> ComparedPair:
    """Return by how much the error of model b exceeds that of model a, sample by sample."""
    rows = tuple(_difference(placement.errors[b] - placement.errors[a]) for placement in tried)
    return ComparedPair(
        a=a,
        b=b,
        placements=rows,
        summary=_mean_difference([rows[i] for i in fair]) if fair else None,
        apart=apart([t.points[a] for t in tried], [t.points[b] for t in tried]),
    )


def _difference(differences: np.ndarray) -> Difference:
    """Return a placement's mean difference, and the noise that its samples leave in it."""
    count = len(differences)
    return _judged(float(differences.mean()), 2 * float(differences.std(ddof=1)) / count**0.5)


def _mean_difference(rows: Sequence[Difference]) -> Difference:
    """Return the mean difference over placements, and its noise.

    Errors of one placement go together, so with two or more placements the spread between them
    counts where it is larger than what the samples alone would give.
    """
    means = np.array([row.mean for row in rows])
    noise = float(norms(np.array([row.noise for row in rows]))) / len(rows)
    if len(rows) > 1:
        factor = STUDENT[len(rows) - 2] if len(rows) - 2 < len(STUDENT) else MANY
        noise = max(noise, factor * float(means.std(ddof=1)) / len(rows) ** 0.5)
    return _judged(float(means.mean()), noise)


def _judged(mean: float, noise: float) -> Difference:
    return Difference(mean=mean, noise=noise, beyond_noise=abs(mean) > noise)


def apart(one: Sequence[np.ndarray], other: Sequence[np.ndarray]) -> Displacement:
    """Return the distance between the balls of two models, once the other is moved onto the one.

    The base frame cannot be seen by a ball in a socket, so a rigid motion between two
    calibrations means nothing; it is taken out (Kabsch's algorithm).

    Args:
        one: Ball centres by one model, placement by placement, shape (N, 3) each [m].
        other: Those of the same samples by the other model.
    """
    A, B = np.concatenate(one), np.concatenate(other)
    gaps = norms(kabsch(B, A).apply(B) - A)
    return Displacement(mean=float(gaps.mean()), max=float(gaps.max()))


def comparison_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    a, b = result.models[pair.a].name, result.models[pair.b].name
    summary = pair.summary
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(result.fair), "placement")
    where = f"over {count} that none was trained on"
    noise = f"noise \N{PLUS-MINUS SIGN}{mm(summary.noise, 3)}, 95 %"
    if not summary.beyond_noise:
        gap = mm(abs(summary.mean), 3)
        return f"{b} and {a} differ by {gap} {where}, which is within the noise ({noise})."
    better, worse = (b, a) if summary.mean < 0 else (a, b)
    rows = [pair.placements[i] for i in result.fair]
    wins = sum(row.beyond_noise and row.mean * summary.mean > 0 for row in rows)
    return (
        f"{better} is better than {worse} by {mm(abs(summary.mean), 3)} {where}, beyond the "
        f"noise ({noise}) on the whole and at {wins} of them."
    )

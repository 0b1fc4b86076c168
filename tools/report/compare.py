"""Several calibrations of one robot on the same data: which is better where, beyond the noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import MukcaError
from ...solver.calibrated import Calibration, CalibrationError, calibrated_robot, load_document
from ...solver.data.measurements import Measurement
from ...solver.data.metrics import evaluate, mean_metrics, socket_centres
from .evidence import measurements_of, predict
from .figures import quantiles

__all__ = ["FORMAT", "ComparisonError", "Contender", "compare", "contenders_of", "shared_data"]

Vector = NDArray[np.float64]
FORMAT = "mukca-comparison-1"
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
    document: Mapping[str, Any]
    calibration: Calibration

    def trained_on(self, measured: Measurement) -> bool:
        """Tell whether it was fitted to these very samples, wherever they lie now."""
        positions = [list(sample.position) for sample in measured.placement.samples]
        return any(
            row["role"] == "train" and [s["position"] for s in row["samples"]] == positions
            for row in self.document["data"]
        )


def contenders_of(files: Sequence[Path]) -> list[Contender]:
    """Return the calibrations in some files, named by their folders.

    Raises:
        CalibrationError: A file is no calibration.
        ComparisonError: They are not of the same joints.
    """
    names = _names(files)
    found: list[Contender] = []
    for file, name in zip(files, names, strict=True):
        document = load_document(file)
        found.append(Contender(name, document, calibrated_robot(document, str(file))))
    first = found[0].calibration.robot
    for file, other in zip(files, found, strict=True):
        joints = other.calibration.robot.joint_names
        if joints != first.joint_names:
            raise ComparisonError(
                f"{file}: its joints are {', '.join(joints)}, but those of {files[0]} are "
                f"{', '.join(first.joint_names)}; only calibrations of one robot can be compared"
            )
    return found


def _names(files: Sequence[Path]) -> list[str]:
    """Return the shortest names that tell files apart: folder, folders, path."""
    for count in (1, 2):
        names = ["/".join(file.resolve().parent.parts[-count:]) for file in files]
        if len({*names, NOMINAL}) == len(names) + 1:
            return names
    if len(set(files)) < len(files):
        raise ComparisonError("a calibration is named twice; name each only once")
    return [str(file) for file in files]


def shared_data(contenders: Sequence[Contender], files: Sequence[Path]) -> list[Measurement]:
    """Return all placements that the calibrations' files hold, each once.

    Raises:
        CalibrationError: A file's samples are damaged.
    """
    found: list[Measurement] = []
    for contender, file in zip(contenders, files, strict=True):
        try:
            placements = measurements_of(contender.document, contenders[0].calibration.robot)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise CalibrationError(f"{file}: damaged calibration.json: {error!r}") from None
        known = [m.placement.positions for m in found]
        found += [
            m
            for m in placements
            if not any(np.array_equal(m.placement.positions, k) for k in known)
        ]
    return found


def compare(contenders: Sequence[Contender], data: Sequence[Measurement]) -> dict[str, Any]:
    """Return the comparison, SI units.

    Args:
        contenders: At least one; the nominal model of the first is compared as well.
        data: What to compare them on.

    Returns:
        ``models``: names, nominal first, with the summary over the placements that none of them
        was trained on (``fair``). ``placements``: per model MAE, quantiles, distance error, and
        whether it was trained there. ``pairs``: each model less the one before it in the list,
        per placement and over the fair ones, with its noise (95 %), and how far
        ``apart`` the two put the ball.
    """
    names = [NOMINAL, *(contender.name for contender in contenders)]
    first = contenders[0].calibration
    points = [
        [first.nominal_ball(m.positions), *(predict(c.calibration, m) for c in contenders)]
        for m in data
    ]
    trained = [[False, *(c.trained_on(m) for c in contenders)] for m in data]
    errors = [[_errors(p, m) for p in of_m] for of_m, m in zip(points, data, strict=True)]
    fair = [i for i, row in enumerate(trained) if not any(row)]
    return {
        "format": FORMAT,
        "robot_name": first.robot.name,
        "models": [_model(k, name, errors, data, points, fair) for k, name in enumerate(names)],
        "placements": [_placement(m, points[i], errors[i], trained[i]) for i, m in enumerate(data)],
        "fair": fair,
        "pairs": [
            _pair(errors, points, fair, a, b) for b in range(1, len(names)) for a in range(b)
        ],
    }


def _errors(points: Vector, measured: Measurement) -> Vector:
    centres = np.repeat(socket_centres(points, measured), measured.counts, axis=0)
    return np.linalg.norm(points - centres, axis=1)


def _model(
    k: int,
    name: str,
    errors: list[list[Vector]],
    data: Sequence[Measurement],
    points: list[list[Vector]],
    fair: list[int],
) -> dict[str, Any]:
    """Return a model's summary over the fair placements; None where there are none."""
    row: dict[str, Any] = {"name": name, "summary": None}
    if fair:
        metrics = [evaluate(points[i][k], data[i]) for i in fair]
        row["summary"] = {
            "mean_absolute_error": float(np.mean([m.mean_absolute_error for m in metrics])),
            "distance_error": mean_metrics(metrics).distance_error,
            **quantiles(np.concatenate([errors[i][k] for i in fair])),
        }
    return row


def _placement(
    measured: Measurement, points: list[Vector], errors: list[Vector], trained: list[bool]
) -> dict[str, Any]:
    return {
        "name": measured.name,
        "samples": list(measured.counts),
        "models": [
            {
                **evaluate(p, measured).as_dict(),
                "quantiles": quantiles(e),
                "trained_on": was,
            }
            for p, e, was in zip(points, errors, trained, strict=True)
        ],
    }


def _pair(
    errors: list[list[Vector]], points: list[list[Vector]], fair: list[int], a: int, b: int
) -> dict[str, Any]:
    """Return by how much the error of model b differs from that of model a, sample by sample."""
    rows = [_difference(of_m[b] - of_m[a]) for of_m in errors]
    return {
        "a": a,
        "b": b,
        "placements": rows,
        "summary": _overall([rows[i] for i in fair]) if fair else None,
        "apart": _apart([p[a] for p in points], [p[b] for p in points]),
    }


def _difference(differences: Vector) -> dict[str, Any]:
    """Return a placement's mean difference, and the noise that its samples leave in it."""
    count = len(differences)
    return _judged(float(differences.mean()), 2 * float(differences.std(ddof=1)) / count**0.5)


def _overall(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the mean difference over placements, and its noise.

    Errors of one placement go together, so with two or more placements the spread between them
    counts where it is larger than what the samples alone would give.
    """
    means = np.array([row["mean"] for row in rows])
    noise = float(np.linalg.norm([row["noise"] for row in rows])) / len(rows)
    if len(rows) > 1:
        factor = STUDENT[len(rows) - 2] if len(rows) - 2 < len(STUDENT) else MANY
        noise = max(noise, factor * float(means.std(ddof=1)) / len(rows) ** 0.5)
    return _judged(float(means.mean()), noise)


def _judged(mean: float, noise: float) -> dict[str, Any]:
    """Return a difference, half the width of its 95 % interval [m], and if that excludes zero."""
    return {"mean": mean, "noise": noise, "beyond_noise": abs(mean) > noise}


def _apart(one: list[Vector], other: list[Vector]) -> dict[str, float]:
    """Return how far the models put the ball apart, once the other is moved onto the one.

    The base frame cannot be seen by a ball in a socket, so a rigid motion between two
    calibrations means nothing; it is taken out (Kabsch's algorithm).
    """
    A, B = np.concatenate(one), np.concatenate(other)
    a, b = A - A.mean(axis=0), B - B.mean(axis=0)
    U, _, V = np.linalg.svd(b.T @ a)
    U[:, 2] *= np.sign(np.linalg.det(U @ V))
    gaps = np.linalg.norm(b @ U @ V - a, axis=1)
    return {"mean": float(gaps.mean()), "max": float(gaps.max())}

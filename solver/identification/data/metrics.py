"""The paper's two metrics of a model's predictions: mean absolute error, and distance error.

A model that shrinks the robot to a point has no scatter of the balls: so the distance between two
sockets is needed, too. Of measured balls, it is the distance from them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from ..robot import rotation_vectors
from .frames import Pose, fit_pose
from .known import CALIPER_DEVIATION
from .measurements import Measurement

FOLDS = 10
"""Parts of a placement of points; each is judged in the frame that the others give."""


@dataclass(frozen=True)
class Metrics:
    """Errors of a model on one placement, or several; all in metres."""

    mean_absolute_error: float
    """Mean over the samples of |Phi(q_i) - mu_k|: Phi(q_i) is the predicted ball of sample i, and
    mu_k the mean of the predicted balls in its socket k. For measured points, mean of |Phi(q_i) -
    F y_i|: y_i is the measured ball, and F the pose of the instrument's frame."""
    max_error: float
    """The largest of these distances."""
    distance_error: float | None
    """|mu1 - mu0| - d, for d the measured distance: positive where the model is too large. Over
    several placements, the mean of the absolute values. None where there is one socket only."""
    orientation_error: float | None = None
    """Mean angle between predicted and measured orientations [rad]; None where none was measured,
    or the model was not asked for them."""

    def as_dict(self) -> dict[str, float | None]:
        """Return the figures by name [m], [rad]."""
        return asdict(self)


def removed_share(before: Metrics, after: Metrics) -> float:
    """Return the share of the mean absolute error that another model removes."""
    error = before.mean_absolute_error
    return 1 - after.mean_absolute_error / error if error > 0 else 0.0


def socket_centres(points: np.ndarray, measured: Measurement) -> np.ndarray:
    """Return the mean of the predicted ball centres in each socket, shape (sockets, 3) [m]."""
    return np.array([points[rows].mean(axis=0) for rows in measured.slices])


def fit_frames(training: Sequence[tuple[np.ndarray, Measurement]]) -> dict[str, Pose]:
    """Return the poses of the frames in which points were measured, by a model's predictions."""
    by_frame: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for points, measured in training:
        if measured.kind == "points":
            by_frame.setdefault(measured.frame, []).append((measured.points, points))
    poses: dict[str, Pose] = {}
    for frame, parts in by_frame.items():
        measured_points, balls = map(np.concatenate, zip(*parts, strict=True))
        poses[frame] = fit_pose(measured_points, balls)
    return poses


def targets(
    points: np.ndarray, measured: Measurement, frames: Mapping[str, Pose] | None = None
) -> np.ndarray:
    """Return the true place of each ball by a model that predicts points, shape (N, 3) [m].

    ``frames`` are poses of the instrument's frames, see :func:`fit_frames`.
    """
    if measured.kind == "sockets":
        return np.repeat(socket_centres(points, measured), measured.counts, axis=0)
    if frames and measured.frame in frames:
        return frames[measured.frame].apply(measured.points)
    places = np.empty_like(points)
    fold = np.arange(len(points)) % FOLDS
    for number in np.unique(fold).tolist():
        part = fold == number
        pose = fit_pose(measured.points[~part], points[~part])
        places[part] = pose.apply(measured.points[part])
    return places


def evaluate(
    points: np.ndarray,
    measured: Measurement,
    frames: Mapping[str, Pose] | None = None,
    rotations: np.ndarray | None = None,
) -> Metrics:
    """Return the metrics of one placement; arguments are those of :func:`targets`.

    And predicted orientations of the ball's link, shape (N, 3, 3); None for no figure.
    """
    places = targets(points, measured, frames)
    errors = np.linalg.norm(points - places, axis=1)
    angle = None
    if rotations is not None and measured.has_orientations:
        frame = (frames or {}).get(measured.frame) or fit_pose(measured.points, points)
        true_rotations = frame.rotation @ measured.rotations
        turns = rotation_vectors(rotations @ true_rotations.swapaxes(1, 2))
        angle = float(np.linalg.norm(turns, axis=1).mean())
    return Metrics(
        mean_absolute_error=float(errors.mean()),
        max_error=float(errors.max()),
        distance_error=_distance_error(points, measured),
        orientation_error=angle,
    )


def _distance_error(points: np.ndarray, measured: Measurement) -> float | None:
    """Return |mu1 - mu0| - d [m]; None where one socket alone has samples."""
    if not measured.has_distance:
        return None
    first, second = socket_centres(points, measured)[:2]
    length = float(np.linalg.norm(second - first))
    return length - measured.distance


def mean_metrics(metrics: Sequence[Metrics]) -> Metrics:
    """Return the metrics of several placements together: means, and the largest of the maxima."""
    lengths = [abs(m.distance_error) for m in metrics if m.distance_error is not None]
    turns = [m.orientation_error for m in metrics if m.orientation_error is not None]
    errors = [m.mean_absolute_error for m in metrics]
    return Metrics(
        mean_absolute_error=float(np.mean(errors)),
        max_error=max(m.max_error for m in metrics),
        distance_error=float(np.mean(lengths)) if lengths else None,
        orientation_error=float(np.mean(turns)) if turns else None,
    )


def cost_terms(points: np.ndarray, measured: Measurement) -> tuple[float, float]:
    """Return inconsistency and distortion, the first two terms of Eq. (5) [m^2]."""
    frames = fit_frames([(points, measured)])
    errors = points - targets(points, measured, frames)
    inconsistency = float(np.sum(errors**2)) / len(points)
    distance_error = _distance_error(points, measured) or 0.0
    return inconsistency, distance_error**2


def found_deviation(points: np.ndarray, measured: Measurement) -> float:
    """Return the root mean square distance of samples from their socket's mean [m]."""
    inconsistency, _ = cost_terms(points, measured)
    return inconsistency**0.5


def is_distorted(points: np.ndarray, measured: Measurement) -> bool:
    """Return True where a model's balls fail to reproduce the distance between the sockets.

    It does where the error is beyond what the caliper and the scatter of the samples explain, 3
    sqrt(s_d^2 + MAE^2 (1/N0 + 1/N1)), or beyond a fifth of the distance.
    """
    metrics = evaluate(points, measured)
    if metrics.distance_error is None:
        return False
    N0, N1 = measured.counts[:2]
    scatter = metrics.mean_absolute_error**2 * (1 / N0 + 1 / N1)
    caliper = measured.distance_deviation or CALIPER_DEVIATION
    by_chance = 3 * (caliper**2 + scatter) ** 0.5
    return abs(metrics.distance_error) > min(by_chance, 0.2 * measured.distance)

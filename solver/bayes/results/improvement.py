"""Improvement by a calibration: errors of distances by the nominal model, and by what is loaded.

The arm itself is unknown, so it is drawn from what is known of it: from the posterior of the
samples trained on, updated by those held out. For each draw the errors of both models follow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...data import CALIPER_DEVIATION, Load, Measurement
from ...results import Better, Improvement, Interval
from ...robot import workspace
from ..inference import Posterior
from .postures import poses_near
from .predicted_errors import NEAR, NEARBY
from .uncertainty import CORRELATED, covariance_of, distance_slopes

Points = Callable[[np.ndarray], np.ndarray]
"""Ball centres that a model predicts for joint positions, (N, m) to (N, 3) [m]."""
DRAWS, PAIRS, MOST = 400, 400, 90
"""Draws of the arm, random distances in the workspace, and samples of a held-out placement."""
INDEPENDENT = 0.5
"""Share of the evidence of held-out samples that counts: errors of poses alike are alike."""
ROUNDING = 1e-9
"""Of a correlation."""


@dataclass(frozen=True)
class Models:
    """The models that are compared."""

    nominal: Points
    """With its ball refitted."""
    loaded: Points
    """``calibrated.urdf``."""
    corrected: bool
    """True if the full model, which corrects joint positions, is another one."""


def better_than_nominal(
    posterior: Posterior,
    load: Load,
    models: Models,
    recorded: Sequence[np.ndarray],
    held_out: Sequence[Measurement] = (),
) -> Better:
    """Return the errors of distances before and now, and the probability that they are smaller.

    Args:
        posterior: What the samples trained on tell of the arm.
        load: Load of the joints while recording.
        models: The models to compare.
        recorded: Joint positions of each placement, shape (N, m) [rad].
        held_out: Placements whose samples and distances bear on the arm, too.
    """
    robot = posterior.model.robot
    neighbourhoods = [poses_near(robot, rows, (NEARBY, 1), NEAR)[0] for rows in recorded]
    neighbourhoods = [q[: len(q) // 2 * 2] for q in neighbourhoods if len(q) > 1]
    q = [workspace(robot, 2 * PAIRS), *neighbourhoods]
    mean, root = _updated(posterior, load, held_out)
    draws = mean + np.random.default_rng(0).standard_normal((DRAWS, len(root))) @ root.T
    parts: list[Improvement] = []
    for rows in q:
        moments = load.moments(robot, rows, None)
        lengths, slopes = distance_slopes(posterior.model, posterior.x, rows, moments)
        parts.append(_improvement(models, rows, lengths, lengths + draws @ slopes.T))
    return Better(
        workspace=parts[0],
        recorded_places=max(parts[1:], key=lambda place: place.now.value, default=None),
    )


def _improvement(
    models: Models, q: np.ndarray, lengths: np.ndarray, truths: np.ndarray
) -> Improvement:
    """Return the errors of distances between pairs of poses, by draws of them (K, N) [m].

    Each draw is of the arm and, with replacement, of the pairs, which are a sample as well.
    """
    pairs = np.random.default_rng(1).integers(truths.shape[1], size=truths.shape)
    truths = np.take_along_axis(truths, pairs, axis=1)

    def errors(distances: np.ndarray) -> np.ndarray:
        return np.median(np.abs(distances[pairs] - truths), axis=1)

    before = errors(_distances(models.nominal(q)))
    now = errors(_distances(models.loaded(q)))
    corrected = errors(lengths) if models.corrected else None
    return Improvement(
        before=_interval(before),
        now=_interval(now),
        corrected=None if corrected is None else _interval(corrected),
        probability=_share(now < before),
        corrected_probability=None if corrected is None else _share(corrected < before),
    )


def _share(better: np.ndarray) -> float:
    """Return a probability by draws, which is never 0 or 1."""
    return (float(np.sum(better)) + 0.5) / (len(better) + 1)


def _distances(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[1::2] - points[::2], axis=1)


def _interval(errors: np.ndarray) -> Interval:
    low, middle, high = np.quantile(errors, (0.16, 0.5, 0.84)).tolist()
    return Interval(value=middle, low=low, high=high)


def _updated(
    posterior: Posterior, load: Load, held_out: Sequence[Measurement]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean change of the unknowns by what was held out, and a root of their covariance.

    With Sigma = L L^T the covariance of the unknowns, A the whitened derivatives of what was held
    out, and r its errors,

        L' = L (1 + L^T A^T A L)^-1/2        mean = -L' L'^T A^T r        Sigma' = f L' L'^T

    where f, at least 1, is by how much r^T r - |L'^T A^T r|^2 is larger than expected: a model that
    held-out samples contradict is known less well than it seems.
    """
    root = _root(covariance_of(posterior))
    evidence = [_evidence(posterior, load, m) for m in held_out if m.kind == "sockets"]
    if not evidence:
        return np.zeros(len(root)), root
    A = np.concatenate([rows for rows, _ in evidence])
    r = np.concatenate([errors for _, errors in evidence])
    whitened = A @ root
    precision = np.linalg.cholesky(np.eye(len(root)) + whitened.T @ whitened)
    root = np.linalg.solve(precision, root.T).T
    along = root.T @ (A.T @ r)
    grown = max(float(r @ r - along @ along) / (INDEPENDENT * len(r)), 1.0)
    return -root @ along, grown**0.5 * root


def _root(covariance: np.ndarray) -> np.ndarray:
    """Return L with L L^T the covariance, but for rounding."""
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    scale = np.where(deviation > 0, deviation, 1.0)
    correlation = covariance / np.outer(scale, scale)
    return deviation[:, None] * np.linalg.cholesky(correlation + ROUNDING * np.eye(len(scale)))


def _evidence(
    posterior: Posterior, load: Load, measured: Measurement
) -> tuple[np.ndarray, np.ndarray]:
    """Return whitened derivatives and errors of a placement: its scatter, and its distance."""
    model = posterior.model
    rows = list[np.ndarray]()
    errors = list[np.ndarray]()
    centres = list[np.ndarray]()
    slopes = list[np.ndarray]()
    noise = np.zeros((3, 3))
    for q, moments in load.by_socket(model.robot, measured):
        points, J, by_joints = model.linearise(posterior.x, q, moments)
        scale = posterior.noise.as_gaussian(by_joints)
        centres.append(points.mean(axis=0))
        slopes.append(J.mean(axis=0))
        noise += CORRELATED * scale.sum(axis=0) / len(q) ** 2
        some = np.unique(np.linspace(0, len(q) - 1, min(len(q), MOST // 2)).astype(int))
        if len(some) < 2:
            continue
        white = np.linalg.inv(np.linalg.cholesky(scale[some]))
        offsets = np.concatenate([(points[some] - centres[-1])[:, :, None], J[some]], axis=2)
        offsets = (white @ offsets).reshape(3 * len(some), -1)
        of_centre = np.linalg.qr(white.reshape(-1, 3))[0]
        offsets = INDEPENDENT**0.5 * (offsets - of_centre @ (of_centre.T @ offsets))
        rows.append(offsets[:, 1:])
        errors.append(offsets[:, 0])
    if measured.has_distance:
        offset = centres[1] - centres[0]
        length = float(np.linalg.norm(offset))
        direction = offset / max(length, 1e-12)
        caliper = measured.distance_deviation or CALIPER_DEVIATION
        deviation = float(caliper**2 + direction @ noise @ direction) ** 0.5
        rows.append((direction @ (slopes[1] - slopes[0]))[None] / deviation)
        errors.append(np.array([length - measured.distance]) / deviation)
    return np.concatenate(rows), np.concatenate(errors)

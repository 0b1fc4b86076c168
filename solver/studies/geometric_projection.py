"""The rigid geometry of least expected loss under the posterior: what ``calibrated.urdf`` holds."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..identification.data import IDENTITY, Load, Samples
from ..identification.inference import Posterior, with_joint_offsets
from ..identification.robot import BallModel, workspace
from .predicted_errors import arm_length, poses_near
from .projections import basis_of, outside, rows_of, unit
from .uncertainty import sum_of_variances

PLACES, POSTURES = 80, 10
"""Number of places near those recorded, and of postures at each."""
PAIRS = 300
"""Number of distances in the workspace."""
AWAY = 0.15
"""Standard deviation of a place from the one recorded, per axis, as a share of the arm's length."""
ROUNDS = 2
"""Times that balls are made linear."""
PARTNERS = 2
"""Number of other measured balls to which the distances of each one count."""
HELD = 1e-3
"""Part of a use's square that a change by one deviation of the prior counts as, so that what no use
shows stays as the fit has it."""
SAME = 1e-3
"""Balls as near to each other as this have no direction [m]."""
Difference = Callable[[np.ndarray], np.ndarray]
"""Makes rows that count, shape (R, k), of columns of balls' errors, shape (N, 3, k); linear."""


@dataclass(frozen=True)
class Use:
    """A use of the arm: what of the balls' errors at some poses counts there."""

    positions: np.ndarray
    """Shape (N, m) [rad]."""
    targets: np.ndarray
    """Positions of the ball, by the posterior's mean, shape (N, 3) [m]."""
    difference: Difference
    variance: float
    """Mean square of what counts of the posterior's own errors, v_k of (A12) [m^2]."""

    def form(
        self,
        ball: BallModel,
        values: np.ndarray,
        x: np.ndarray,
        L: np.ndarray,
    ) -> np.ndarray:
        """Return F of the expected mean square [x, 1]^T F [x, 1] of what counts, (n + 1, n + 1).

        The geometry is linear about the values, where x is as given; it changes by L x.
        """
        linear = ball.linearise(values, self.positions)
        errors = linear.points - self.targets
        rows = self.difference(np.dstack([linear.by_parameters, errors]))
        slopes = rows[:, :-1] @ L
        at_zero = rows[:, -1] - slopes @ x
        affine = np.column_stack([slopes, at_zero])
        form = affine.T @ affine / len(affine)
        form[-1, -1] += self.variance
        return form


def project_to_geometry(
    posterior: Posterior,
    load: Load,
) -> np.ndarray:
    """Return the rigid geometry of least expected loss (A12), shape (geometry,) [m, rad].

    It is that of the fit where nothing beyond the geometry was found.
    """
    ball = posterior.model.ball
    start = with_joint_offsets(posterior)
    if not posterior.deflection.beyond_zeros.extensions:
        return start
    uses = _uses(posterior, load)
    n = len(start)
    L = np.linalg.cholesky(posterior.prior_covariance[:n, :n])
    change = np.zeros(n)
    for _ in range(ROUNDS):
        values = start + L @ change
        change = _least([use.form(ball, values, change, L) for use in uses])
    return start + L @ change


def _least(forms: list[np.ndarray]) -> np.ndarray:
    """Return the x of the least sum of uses' squares, each as a share of its own least, (A12).

    The square of a use is [x, 1]^T F [x, 1], with its form F.
    """
    total = np.zeros_like(forms[0])
    for form in forms:
        shares = form / form[-1, -1]
        ends = np.append(_minimum(shares), 1.0)
        total += form / (ends @ form @ ends)
    return _minimum(total)


def _minimum(form: np.ndarray) -> np.ndarray:
    """Return the x of the least [x, 1]^T F [x, 1] + HELD |x|^2, shape (n,)."""
    H = form[:-1, :-1] + HELD * np.eye(len(form) - 1)
    return -np.linalg.solve(H, form[:-1, -1])


def _uses(
    posterior: Posterior,
    load: Load,
) -> list[Use]:
    """Return the uses that count: samples, points and distances near them, distances anywhere."""
    robot = posterior.model.robot
    margin = AWAY * arm_length(robot)
    q, places = poses_near(robot, posterior.data.q, (PLACES, POSTURES), margin)
    nearby = load.at(robot, q)
    anywhere = load.at(robot, workspace(robot, 2 * PAIRS))

    uses = [
        *_in_sockets(posterior),
        *_measured(posterior),
        _use(posterior, nearby, lambda errors: rows_of(without_mean(errors, places))),
        _distances(posterior, nearby),
        _distances(posterior, anywhere),
    ]
    return [use for use in uses if use.variance]


def _in_sockets(posterior: Posterior) -> Iterator[Use]:
    """Yield the uses that samples in sockets are: a point, and distances between bases.

    A sample of a point counts by its robust weight, and so it does in its socket's mean.
    """
    data = posterior.data
    samples = data.only(data.seated)
    sockets = samples.sockets
    weights = posterior.weights[data.seated]
    roots = np.sqrt(weights)[:, None, None]
    means = _means(sockets, weights)
    visited = np.unique(sockets)
    bases = np.array([name for name, _ in data.labels])[visited]
    pairs = np.nonzero(np.triu(bases[:, None] != bases))
    between_bases = _lengths(posterior.centres[visited], *pairs)

    differences: tuple[Difference, ...] = (
        lambda errors: rows_of(roots * without_mean(errors, sockets)),
        lambda errors: between_bases(np.tensordot(means, errors, axes=1)),
    )
    for difference in differences:
        use = _use(posterior, samples, difference)
        yield replace(use, targets=posterior.centres[sockets])


def _measured(posterior: Posterior) -> Iterator[Use]:
    """Yield the uses that measured balls are: points in an instrument's frame, and distances.

    No arm knows the frame, so its best motion is taken out: with Q an orthonormal basis of what
    motions do to all balls, what counts of errors e is e - Q Q^T e.
    """
    data = posterior.data
    generator = np.random.default_rng(0)
    frames = data.measured_in[data.measured_in >= 0]
    for frame in np.unique(frames):
        is_ball = (data.measured_in == frame) & ~data.turned
        rows = np.flatnonzero(is_ball)
        if 3 * len(rows) <= posterior.model.geometry:
            continue  # a geometry can meet so few whatever they are
        samples = data.only(rows)
        Q = basis_of(IDENTITY.slopes(posterior.predict(samples)))

        yield _use(posterior, samples, lambda errors, Q=Q: outside(rows_of(errors), Q))
        first = np.tile(rows, PARTNERS)
        seconds = [generator.permutation(rows) for _ in range(PARTNERS)]
        yield _distances(posterior, data.only(np.concatenate([first, *seconds])))


def _distances(
    posterior: Posterior,
    samples: Samples,
) -> Use:
    """Return the use that measures distances, from the first half of the poses to the second."""
    points = posterior.predict(samples)
    first, second = np.arange(len(points) // 2 * 2).reshape(2, -1)
    return _use(posterior, samples, _lengths(points, first, second))


def _lengths(
    points: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
) -> Difference:
    """Return what counts where lengths do: errors along the way from first points to second ones.

    The way from a point to itself is zero.
    """
    offsets = points[second] - points[first]
    directions = unit(offsets)
    directions[np.linalg.norm(offsets, axis=1) <= SAME] = 0.0

    return lambda errors: np.einsum(
        "ni,nik->nk", directions, errors[second] - errors[first]
    )


def _use(
    posterior: Posterior,
    samples: Samples,
    difference: Difference,
) -> Use:
    """Return a use at poses at which the full model says where the ball is, and how surely.

    Its variance is the mean of s^T Sigma s, with s the derivatives of an error that counts by the
    unknowns.
    """
    points, slopes, _ = posterior.linearise(samples)
    rows = difference(slopes)
    # of error curves, few poses at a time need few coefficients
    has_curves = posterior.deflection.curves is not None
    parts = np.array_split(rows, PLACES if has_curves else 1)
    variance = sum(sum_of_variances(part, posterior.of_unknowns) for part in parts)
    return Use(samples.q, points, difference, variance / max(len(rows), 1))


def without_mean(
    values: np.ndarray,
    places: np.ndarray,
) -> np.ndarray:
    """Return values, shape (N, ...), less their mean at each place, by places of shape (N,)."""
    means = np.tensordot(_means(places, np.ones(len(places))), values, axes=1)
    _, place = np.unique(places, return_inverse=True)
    return values - means[place]


def _means(
    places: np.ndarray,
    weights: np.ndarray,
) -> np.ndarray:
    """Return the matrix of the weighted means at each place, shape (places, N)."""
    shares = (np.unique(places)[:, None] == places) * weights
    return shares / shares.sum(axis=1, keepdims=True)

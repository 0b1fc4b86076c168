"""A quick, robust fit of a rigid arm to samples, without the known distances.

Gauss-Newton steps with Student's noise; priors of fixed width hold the arm, and its scale, nominal.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import log

import numpy as np

from ..bayes.model import NU, extend
from ..bayes.model.effects import JOINT_OFFSET
from ..data import Measurement
from ..robot import BallModel, Robot, choose_parameters
from .hypotheses import BALL, widths_of

SCALE = 1e-5
"""Standard deviation of the prior that holds the arm's scale at nominal."""
ITERATIONS = 40
MAX_OFFSET = np.deg2rad(30)
"""Prior standard deviation of joint offsets in a search [rad]."""
SEED_ITERATIONS = 6
"""Iterations for the ball's place, and joint offsets."""
SETTLED = 1e-2
"""Relative change of the noise, and change of the unknowns in widths, at which a fit ends."""
LARGEST_STEP = 0.2
"""Of any unknown in an iteration [m], [rad]."""
SMALLEST = 1e-7
"""Noise is never taken for less [m]."""
UNEXPLAINED = 5e-3
"""Largest error of a fit to sound recordings [m]."""
BACKLASH_NOISE = 1.9e-3
"""The same for arms made of servos [m]: their backlash moves whole sockets."""
ENOUGH, LEAST = 4000, 20
"""Samples that a fit uses at most, about, and at least of each socket."""
ABOUT, FEW = 120, 10
"""The same of the fit about which hypotheses are linearised."""


@dataclass(frozen=True)
class Samples:
    """Joint positions and their sockets."""

    positions: np.ndarray
    """Shape (N, m)."""
    sockets: np.ndarray
    """Index of each sample's socket, shape (N,)."""

    @cached_property
    def count(self) -> int:
        """Number of sockets."""
        return int(self.sockets.max()) + 1

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """Indices of the samples in each socket."""
        return [np.flatnonzero(self.sockets == k) for k in range(self.count)]

    @cached_property
    def order(self) -> np.ndarray | slice:
        """Socket after socket, as they mostly come."""
        ascending = bool((np.diff(self.sockets) >= 0).all())
        return slice(None) if ascending else np.argsort(self.sockets, kind="stable")

    @cached_property
    def starts(self) -> np.ndarray:
        """First index of each socket in that order."""
        return np.searchsorted(self.sockets[self.order], np.arange(self.count))

    def is_overdetermined(self, unknowns: int) -> bool:
        """Return True for twice as many numbers as unknowns, the sockets' centres left out."""
        return 3 * (len(self.sockets) - self.count) >= 2 * unknowns

    def thinned(self, enough: int, least: int = 1) -> "Samples":
        """Return about so many of the samples, evenly from each socket, and so many of it."""
        enough = max(enough // self.count, least)
        kept = [r[np.linspace(0, len(r) - 1, min(len(r), enough)).astype(int)] for r in self.rows]
        few = np.concatenate(kept)
        return Samples(self.positions[few], self.sockets[few])


def samples_of(measurements: Sequence[Measurement]) -> Samples:
    """Return the samples of placements, socket after socket."""
    counts = [count for m in measurements for count in m.counts]
    return Samples(
        np.concatenate([m.positions for m in measurements]),
        np.repeat(np.arange(len(counts)), counts),
    )


@dataclass(frozen=True)
class RigidFit:
    """The result of a fit."""

    centres: np.ndarray
    """Centres of the sockets, shape (S, 3) [m]."""
    errors: np.ndarray
    """Distance of each sample from its socket's centre, shape (N,) [m]."""
    error: float
    """Mean of the errors by the samples' robust weights [m]."""
    noise: float
    """Scale of the noise per axis [m], corrected for the number of fitted unknowns."""
    x: np.ndarray
    """Change of the parameters from nominal, and joint offsets if any, shape (n,) [m, rad]."""


class RigidModel:
    """An arm whose joint origins are free near nominal; with ``zeros`` joints have offsets, too."""

    def __init__(self, robot: Robot, *, zeros: bool = False) -> None:
        self.robot, self.zeros, self.parameters = robot, zeros, choose_parameters(robot)
        self._model = model = extend(robot, self.parameters, [JOINT_OFFSET.name] if zeros else [])
        self._least = BACKLASH_NOISE if zeros else SMALLEST
        offsets = np.full(model.size - model.geometry, JOINT_OFFSET.typical_shift)
        self.widths = np.append(widths_of(self.parameters), offsets)
        of_place = [p.index for p in self.parameters if p.of_ball and p.unit == "m"]
        self._place = BallModel(robot, of_place)
        by_scale = model.by_scale()
        self.by_scale = by_scale[: model.geometry]
        self._prior = np.diag(self.widths**-2) + np.outer(by_scale, by_scale) / SCALE**2

    def points(self, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Return ball centres for unknowns, shape (n,), and joint positions, (N, m), as (N, 3)."""
        return self._model.predict(x, q, np.tile(0 * q, 3))

    def nominal_errors(self, variants: Sequence[Samples]) -> list[float]:
        """Return the mean errors by the nominal model, its ball put right, of each reading [m]."""
        joints = np.arange(len(self.robot.actuated) if self.zeros else 0)
        every = np.tile(joints, (len(variants), 1))
        return self._seeds(variants, every, JOINT_OFFSET.typical_shift)[1].tolist()

    def nominal_offsets(self, variants: Sequence[Samples], joints: np.ndarray) -> np.ndarray:
        """Return the best offsets of joints, shape (V, J), by the nominal model [rad]."""
        return self._seeds(variants, joints, MAX_OFFSET)[0][:, 3:]

    def _seeds(
        self, variants: Sequence[Samples], joints: np.ndarray, width: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return errors of the ball's place, and joint offsets, (V, 3 + J); and errors left."""
        samples, V = variants[0], len(variants)
        N, m = samples.positions.shape
        q = np.stack([one.positions for one in variants], axis=1)
        linear = self._place.linearise(self._place.nominal, q.reshape(-1, m))
        points = linear.points.reshape(N, V, 3)
        by_joints = linear.by_joints.reshape(N, V, 3, m)[:, np.arange(V)[:, None], :, joints]
        parts = points[..., None], linear.by_parameters.reshape(N, V, 3, 3)
        values = np.concatenate([*parts, np.moveaxis(by_joints, (0, 1, 2), (1, 3, 0))], axis=3)
        widths = np.array([BALL] * 3 + [width] * joints.shape[1])
        off = np.zeros((V, len(widths)))
        e = points - _medians(points, samples)[samples.sockets]
        noise = typical(e)
        for _ in range(SEED_ITERATIONS):
            noise = typical(e)
            weights = robust_weights(e, noise)
            centred = values - _means(values, samples, weights)[samples.sockets]
            slopes = centred[..., 1:].swapaxes(0, 1).reshape(V, 3 * N, -1)
            A = (slopes * np.repeat(weights.T, 3, axis=1)[:, :, None]).swapaxes(1, 2)
            H = A @ slopes + np.eye(len(widths)) * (noise[:, None, None] / widths) ** 2
            e = centred[..., 0].swapaxes(0, 1).reshape(V, 3 * N, 1)
            steps = np.linalg.solve(H, A @ e)
            off = steps[:, :, 0]
            e = (e - slopes @ steps).reshape(V, N, 3).swapaxes(0, 1)
        errors = np.linalg.norm(e, axis=2)
        return off, np.average(errors, axis=0, weights=robust_weights(e, noise))

    def fitted(self, samples: Samples) -> Robot:
        """Return the arm as some samples show it."""
        values = self._model.values(self.fit(samples).x)
        return self.robot.with_origins(self._model.ball.origins(values))

    def fit(
        self,
        samples: Samples,
        iterations: int = ITERATIONS,
        start: np.ndarray | None = None,
        linear: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> RigidFit:
        """Return the fit from unknowns ``start``, or to ``linear``: balls and derivatives there."""
        few = samples.thinned(ENOUGH, LEAST) if linear is None else samples
        P, widths = self._prior, self.widths
        first = np.zeros(len(widths)) if start is None else start

        def balls(x: np.ndarray, q: np.ndarray) -> np.ndarray:
            return self.points(x, q) if linear is None else linear[0] + linear[1] @ (x - first)

        x, points = first, balls(first, few.positions)
        centres = _medians(points, few)
        noise = float(typical(points - centres[few.sockets]))
        for _ in range(iterations):
            points, by_unknowns = linear or self.linearised(x, few.positions)
            points = balls(x, few.positions) if linear else points
            weights = robust_weights(points - centres[few.sockets], noise)
            centres = _means(points, few, weights)
            e = points - centres[few.sockets]
            slopes = _means(by_unknowns, few, weights)
            D = by_unknowns - slopes[few.sockets]
            A = (D * weights[:, None, None] / noise**2).reshape(-1, len(widths))
            H = A.T @ D.reshape(-1, len(widths)) + P
            covariance = np.linalg.inv(H)
            step = -covariance @ (A.T @ e.ravel() + P @ x)
            step *= min(1.0, LARGEST_STEP / float(np.abs(step).max()))
            x = x + step
            centres = centres + slopes @ step
            left: np.ndarray = np.sum((e + D @ step) ** 2, axis=1)
            fitted = 3 * few.count + len(widths) - float(np.sum(covariance * P))
            variance = float(weights @ left) / max(3 * len(e) - fitted, 1.0)
            before, noise = noise, max(variance**0.5, self._least)
            change = max(abs(log(noise / before)), float(np.abs(step / widths).max()))
            if change < SETTLED:
                break
        points = balls(x, samples.positions)
        centres = _means(points, samples, robust_weights(points - centres[samples.sockets], noise))
        left = points - centres[samples.sockets]
        errors = np.linalg.norm(left, axis=1)
        mean = float(np.average(errors, weights=robust_weights(left, noise)))
        return RigidFit(centres, errors, mean, noise, x)

    def linearised(self, x: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the balls at some poses, shape (N, 3) [m], and their derivatives, (N, 3, n)."""
        return self._model.linearise(x, q, np.tile(0 * q, 3))[:2]


def _medians(points: np.ndarray, samples: Samples) -> np.ndarray:
    return np.array([median(points[rows]) for rows in samples.rows])


def _means(values: np.ndarray, samples: Samples, weights: np.ndarray) -> np.ndarray:
    """Return the weighted mean in each socket of values of shape (N, ...)."""
    weights = weights.reshape(*weights.shape, *[1] * (values.ndim - weights.ndim))
    sums = np.add.reduceat((weights * values)[samples.order], samples.starts, axis=0)
    return sums / np.add.reduceat(weights[samples.order], samples.starts, axis=0)


def median(values: np.ndarray) -> np.ndarray:
    """Return the median over the first axis; for few values NumPy's own takes ten times as long."""
    values, n = np.sort(values, axis=0), len(values)
    return (values[(n - 1) // 2] + values[n // 2]) / 2


def typical(errors: np.ndarray) -> np.ndarray:
    """Return the scale of errors per axis, shape (N, ..., 3), by their median, shape (...) [m]."""
    square = median(np.einsum("...i,...i->...", errors, errors))
    return np.maximum(square / 2.366, SMALLEST**2) ** 0.5  # 2.366: the median of chi2 with 3


def robust_weights(errors: np.ndarray, noise: float | np.ndarray) -> np.ndarray:
    """Return the robust weight of each error, (nu + 3) / (nu + e^2 / s^2)."""
    return (NU + 3) / (NU + np.einsum("...i,...i->...", errors, errors) / noise**2)

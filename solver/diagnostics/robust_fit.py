"""A quick, robust fit of a rigid arm to samples, without the known distances.

Gauss-Newton steps with Student's noise; priors of fixed width hold the arm, and its scale, nominal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..bayes.model import extend
from ..bayes.model.effects import JOINT_OFFSET
from ..robot import BallModel, Robot, choose_parameters
from .hypotheses import (
    ARMS,
    BALL,
    SMALLEST,
    Samples,
    Scene,
    means,
    medians,
    precision,
    robust_weights,
    typical,
    widths_of,
)

SCALE = 1e-5
"""Standard deviation of the prior that holds the arm's scale at nominal; points tell it."""
ITERATIONS = 40
MAX_OFFSET = np.deg2rad(30)
"""Prior standard deviation of joint offsets in a search [rad]."""
SEED_ITERATIONS = 6
"""Iterations for the ball's place, and joint offsets."""
SETTLED = 1e-2
"""Relative change of the noise, and change of the unknowns in widths, at which a fit ends."""
LARGEST_STEP = 0.2
"""Of any unknown in an iteration [m], [rad]."""
TURN = 1.0
"""Width of the prior of a frame's turn in a step [rad]."""
UNEXPLAINED = 5e-3
"""Largest error of a fit to sound recordings [m]."""
BACKLASH_NOISE = 1.9e-3
"""The same for arms made of servos [m]: their backlash moves whole sockets."""
ENOUGH, LEAST = 4000, 20
"""Samples that a fit uses at most, about, and at least of each socket."""
ABOUT, FEW = 120, 10
"""The same of the fit about which hypotheses are linearised."""


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
    R: np.ndarray
    """Rotations of the instruments' frames, by the seats, shape (S, 3, 3)."""


Linear = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Balls, and their derivatives by unknowns and by joints."""


class RigidModel:
    """An arm whose joint origins are free near nominal; with ``zeros`` joints have offsets, too."""

    def __init__(self, robot: Robot, *, zeros: bool = False) -> None:
        self.robot, self.zeros, self.parameters = robot, zeros, choose_parameters(robot)
        self._model = model = extend(
            robot, self.parameters, [JOINT_OFFSET.name] if zeros else []
        )
        self._least = BACKLASH_NOISE if zeros else SMALLEST
        offsets = np.full(model.size - model.geometry, JOINT_OFFSET.typical_shift)
        self.widths = np.append(widths_of(self.parameters), offsets)
        self.by_scale = model.by_scale()
        of_place = [p.index for p in self.parameters if p.of_ball and p.unit == "m"]
        self._place = BallModel(robot, of_place)

    def points(self, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Return ball centres for unknowns, shape (n,), and joint positions, (N, m), as (N, 3)."""
        return self._model.predict(x, q, np.tile(0 * q, 3))

    def linearised(self, x: np.ndarray, q: np.ndarray) -> Linear:
        """Return balls, (N, 3), and derivatives by unknowns, (N, 3, n), and joints, (N, 3, m)."""
        return self._model.linearise(x, q, np.tile(0 * q, 3))

    def nominal_errors(self, variants: Sequence[Samples]) -> list[float]:
        """Return the mean errors by the nominal model, its ball put right, of each reading [m]."""
        joints = np.arange(len(self.robot.actuated) if self.zeros else 0)
        of_variants = np.tile(joints, (len(variants), 1))
        _, errors = self._seeds(variants, of_variants, JOINT_OFFSET.typical_shift)
        return errors.tolist()

    def nominal_offsets(
        self, variants: Sequence[Samples], joints: np.ndarray
    ) -> np.ndarray:
        """Return the best offsets of joints, shape (V, J), by the nominal model [rad]."""
        return self._seeds(variants, joints, MAX_OFFSET)[0][:, 3:]

    def _seeds(
        self, variants: Sequence[Samples], joints: np.ndarray, width: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return errors of the ball's place, and joint offsets, (V, 3 + J); and errors left."""
        samples, V = variants[0], len(variants)
        N, m = samples.positions.shape
        q = np.stack([variant.positions for variant in variants], axis=1)
        linear = self._place.linearise(self._place.nominal, q.reshape(-1, m))
        points = linear.points.reshape(N, V, 3)
        by_place = linear.by_parameters.reshape(N, V, 3, 3)
        by_all_joints = linear.by_joints.reshape(N, V, 3, m)
        by_joints = np.take_along_axis(by_all_joints, joints[None, :, None], axis=3)
        values = np.concatenate([points[..., None], by_place, by_joints], axis=3)
        J, turns = joints.shape[1], 3 * len(samples.frames)
        widths = np.array([BALL] * 3 + [width] * J + [TURN] * turns)
        offsets = np.zeros((V, 3 + J))
        places = points - samples.offsets(samples.aligned(points, np.ones((N, V))))
        e = places - medians(places, samples)[samples.sockets]
        noise = typical(e)
        for _ in range(SEED_ITERATIONS):
            noise = typical(e)
            weights = robust_weights(e, noise)
            places = _with_turns(values, offsets, samples, weights)
            centres = means(places, samples, weights)
            centred = places - centres[samples.sockets]
            by_variant = centred.swapaxes(0, 1).reshape(V, 3 * N, -1)
            off, slopes = by_variant[..., :1], by_variant[..., 1:]
            A = (slopes * np.repeat(weights.T, 3, axis=1)[:, :, None]).swapaxes(1, 2)
            prior = np.eye(len(widths)) * (noise[:, None, None] / widths) ** 2
            steps = np.linalg.solve(A @ slopes + prior, A @ off)
            offsets = steps[:, : 3 + J, 0]
            e = (off - slopes @ steps).reshape(V, N, 3).swapaxes(0, 1)
        weights = robust_weights(e, noise)
        errors = np.linalg.norm(e, axis=2)
        return offsets, np.average(errors, axis=0, weights=weights)

    def fitted(self, samples: Samples) -> Robot:
        """Return the arm as some samples show it."""
        values = self._model.values(self.fit(samples).x)
        return self.robot.with_origins(self._model.ball.origins(values))

    def fit(
        self,
        samples: Samples,
        iterations: int = ITERATIONS,
        start: np.ndarray | None = None,
        linear: Linear | None = None,
    ) -> RigidFit:
        """Return the fit from unknowns ``start``, or to ``linear``: balls and derivatives there."""
        few = samples.thinned(ENOUGH, LEAST) if linear is None else samples
        n, turns = len(self.widths), 3 * len(few.frames)
        unknowns = n + turns
        P = np.eye(unknowns) / TURN**2
        P[:n, :n] = precision(self.widths, self.by_scale, ARMS if turns else SCALE)
        first = np.zeros(n) if start is None else start

        def balls(x: np.ndarray, q: np.ndarray) -> np.ndarray:
            return (
                self.points(x, q)
                if linear is None
                else linear[0] + linear[1] @ (x - first)
            )

        x, points = first, balls(first, few.positions)
        rotations = few.robustly_aligned(points)
        points = points - few.offsets(rotations)
        centres = medians(points, few)
        noise = float(typical(points - centres[few.sockets]))
        for _ in range(iterations):
            points, slopes, _ = linear or self.linearised(x, few.positions)
            if linear:
                points = balls(x, few.positions)
            arms = few.offsets(rotations)
            points = points - arms
            slopes = np.concatenate([slopes, few.by_turns(arms)], axis=2)
            weights = robust_weights(points - centres[few.sockets], noise)
            centres = means(points, few, weights)
            of_centres = means(slopes, few, weights)
            e = points - centres[few.sockets]
            D = slopes - of_centres[few.sockets]
            A = (D * weights[:, None, None] / noise**2).reshape(-1, unknowns)
            H = A.T @ D.reshape(-1, unknowns) + P
            covariance = np.linalg.inv(H)
            step = -covariance @ (A.T @ e.ravel() + P[:, :n] @ x)
            step *= min(1.0, LARGEST_STEP / float(np.abs(step).max()))
            x = x + step[:n]
            rotations = few.turned(rotations, step[n:])
            centres = centres + of_centres @ step
            squares: np.ndarray = np.sum((e + D @ step) ** 2, axis=1)
            degrees = 3 * few.count + unknowns - float(np.sum(covariance * P))
            variance = float(weights @ squares) / max(3 * len(e) - degrees, 1.0)
            before, noise = noise, max(variance**0.5, self._least)
            # however the links' frames are drawn
            change = max(abs(log(noise / before)), float(step @ P @ step) ** 0.5)
            if change < SETTLED:
                break
        points = balls(x, samples.positions) - samples.offsets(rotations)
        weights = robust_weights(points - centres[samples.sockets], noise)
        centres = means(points, samples, weights)
        e = points - centres[samples.sockets]
        errors = np.linalg.norm(e, axis=1)
        mean = float(np.average(errors, weights=robust_weights(e, noise)))
        return RigidFit(centres, errors, mean, noise, x, rotations)

    def refitted(
        self, scene: Scene, start: np.ndarray | None = None
    ) -> tuple[Scene, float]:
        """Return a scene about a fit to its samples, and the noise of that [m]."""
        few = scene.samples.thinned(ABOUT, FEW)
        fit = self.fit(few, start=start)
        about = replace(scene, x=fit.x, centres=fit.centres, R=fit.R)
        return about, fit.noise


def _with_turns(
    values: np.ndarray, offsets: np.ndarray, samples: Samples, weights: np.ndarray
) -> np.ndarray:
    """Return places of seats and their derivatives, those by the turns of frames behind them.

    Args:
        values: Balls of V models and their derivatives by k unknowns, shape (N, V, 3, 1 + k).
        offsets: Errors of the unknowns at which frames are turned, shape (V, k).
        samples: The samples, with what was measured.
        weights: Of the samples in each model, shape (N, V).
    """
    if not samples.frames:
        return values
    points, slopes = values[..., 0], values[..., 1:]
    balls = points - np.einsum("nvij,vj->nvi", slopes, offsets)
    arms = samples.offsets(samples.aligned(balls, weights))
    places = (points - arms)[..., None]
    return np.concatenate([places, slopes, samples.by_turns(arms)], axis=3)

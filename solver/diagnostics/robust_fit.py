"""A quick, robust fit of a rigid arm to samples, without the known distances.

Gauss-Newton steps with Student's noise; priors of fixed width hold the arm, and its scale, nominal.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..identification.data import Samples
from ..identification.effects import JOINT_OFFSET
from ..identification.model import Prediction, extend
from ..identification.robot import Robot, choose_parameters
from .hypotheses import (
    ARMS,
    SMALLEST,
    Scene,
    SeatSamples,
    means,
    medians,
    precision,
    robust_weights,
    typical,
    widths_of,
)
from .nominal_fit import TURN, NominalFit

SCALE = 1e-5
"""Standard deviation of the prior that holds the arm's scale at nominal; points tell it."""
ITERATIONS = 40
SETTLED = 1e-2
"""Relative change of the noise, and change of the unknowns in widths, at which a fit ends."""
LARGEST_STEP = 0.2
"""Of any unknown in an iteration [m], [rad]."""
UNEXPLAINED = 5e-3
"""Largest error of a fit to sound recordings [m]."""
BACKLASH_NOISE = 1.9e-3
"""The same for arms made of servos [m]: their backlash moves whole sockets."""
ENOUGH = 4000
"""Samples that a fit uses at most, about."""
LEAST = 20
"""Samples of each socket that it uses at least."""
ABOUT = 120
"""Samples of the fit about which hypotheses are linearised, about."""
FEW = 10
"""Samples of each socket in that fit."""


@dataclass(frozen=True)
class _State:
    """The unknowns of a fit after some iterations."""

    x: np.ndarray
    """Change of the parameters from nominal, and joint offsets if any, shape (n,) [m, rad]."""
    R: np.ndarray
    """Rotations of the instruments' frames, by the seats, shape (S, 3, 3)."""
    centres: np.ndarray
    """Places of the seats, shape (S, 3) [m]."""
    noise: float
    """Scale of the noise per axis [m], corrected for the number of fitted unknowns."""


@dataclass(frozen=True)
class RigidFit(_State):
    """The result of a fit."""

    errors: np.ndarray
    """Distance of each sample from the place of its seat, shape (N,) [m]."""
    error: float
    """Mean of the errors by the samples' robust weights [m]."""


@dataclass(frozen=True)
class _LinearArm:
    """Balls of some samples, linear in the unknowns about those at which they were computed."""

    linear: Prediction
    first: np.ndarray

    def points(
        self,
        x: np.ndarray,
        q: np.ndarray,
    ) -> np.ndarray:
        """Return ball centres, (N, 3)."""
        return self.linear.points + self.linear.by_unknowns @ (x - self.first)

    def linearised(
        self,
        x: np.ndarray,
        q: np.ndarray,
    ) -> Prediction:
        """Return balls, and their derivatives."""
        return self.linear._replace(points=self.points(x, q))


class RigidModel:
    """An arm whose joint origins are free near nominal; with ``zeros`` joints have offsets, too."""

    def __init__(
        self,
        robot: Robot,
        *,
        zeros: bool = False,
    ) -> None:
        self.robot = robot
        self.zeros = zeros
        self.parameters = choose_parameters(robot)
        effects = [JOINT_OFFSET.name] if zeros else []
        self._model = model = extend(robot, self.parameters, effects)
        self._least = BACKLASH_NOISE if zeros else SMALLEST
        offsets = np.full(model.size - model.geometry, JOINT_OFFSET.typical_shift)
        self.widths = np.append(widths_of(self.parameters), offsets)
        self.by_scale = model.by_scale()
        self.nominal = NominalFit(robot, zeros=zeros)

    def points(
        self,
        x: np.ndarray,
        q: np.ndarray,
    ) -> np.ndarray:
        """Return ball centres for unknowns, shape (n,), and joint positions, (N, m), as (N, 3)."""
        return self._model.predict(x, Samples.unloaded(q))

    def linearised(
        self,
        x: np.ndarray,
        q: np.ndarray,
    ) -> Prediction:
        """Return balls, (N, 3), and derivatives by unknowns, (N, 3, n), and joints, (N, 3, m)."""
        return self._model.linearise(x, Samples.unloaded(q))

    def fitted(self, samples: SeatSamples) -> Robot:
        """Return the arm as some samples show it."""
        values = self._model.values(self.fit(samples).x)
        return self.robot.with_origins(self._model.ball.origins(values))

    def fit(
        self,
        samples: SeatSamples,
        iterations: int = ITERATIONS,
        start: np.ndarray | None = None,
        linear: Prediction | None = None,
    ) -> RigidFit:
        """Return the fit from unknowns ``start``, or to ``linear``: balls and derivatives there."""
        x = np.zeros(len(self.widths)) if start is None else start
        if linear is None:
            arm, few = self, samples.thinned(ENOUGH, LEAST)
        else:
            arm, few = _LinearArm(linear, x), samples
        P = self._prior(few)
        state = _begun(few, arm.points(x, few.q), x)
        for _ in range(iterations):
            balls = arm.linearised(state.x, few.q)
            state, change = self._improved(few, balls, state, P)
            if change < SETTLED:
                break
        return _result(samples, arm.points(state.x, samples.q), state)

    def _prior(self, samples: SeatSamples) -> np.ndarray:
        """Return the inverse covariance of the unknowns, then of the turns of frames."""
        n, turns = len(self.widths), 3 * len(samples.frames)
        P = np.eye(n + turns) / TURN**2
        scale = ARMS if turns else SCALE
        P[:n, :n] = precision(self.widths, self.by_scale, scale)
        return P

    def _improved(
        self,
        samples: SeatSamples,
        balls: Prediction,
        state: _State,
        P: np.ndarray,
    ) -> tuple[_State, float]:
        """Return the state after a Gauss-Newton step, and by how much it changed.

        With errors e and derivatives D about the seats' weighted means, the weights W, the noise s
        and the prior P::

            step = -(D^T W D / s^2 + P)^-1 (D^T W e / s^2 + P x)
        """
        points, slopes, _ = balls
        seats, n, unknowns = samples.sockets, len(state.x), len(P)
        arms = samples.offsets(state.R)
        points = points - arms
        slopes = np.concatenate([slopes, samples.by_turns(arms)], axis=2)
        weights = robust_weights(points - state.centres[seats], state.noise)
        centres = means(points, samples, weights)
        of_centres = means(slopes, samples, weights)
        e = points - centres[seats]
        D = slopes - of_centres[seats]
        weighted = D * weights[:, None, None] / state.noise**2
        A = weighted.reshape(-1, unknowns)
        covariance = np.linalg.inv(A.T @ D.reshape(-1, unknowns) + P)
        gradient = A.T @ e.ravel() + P[:, :n] @ state.x
        step = -covariance @ gradient
        step *= LARGEST_STEP / max(float(np.abs(step).max()), LARGEST_STEP)
        squares = np.sum((e + D @ step) ** 2, axis=1)
        fitted = 3 * samples.count + unknowns - float(np.sum(covariance * P))
        variance = float(weights @ squares) / max(3 * len(e) - fitted, 1.0)
        noise = max(variance**0.5, self._least)
        after = _State(
            x=state.x + step[:n],
            R=samples.turned(state.R, step[n:]),
            centres=centres + of_centres @ step,
            noise=noise,
        )
        # however the links' frames are drawn
        in_widths = float(step @ P @ step) ** 0.5
        return after, max(abs(log(noise / state.noise)), in_widths)

    def refitted(
        self,
        scene: Scene,
        start: np.ndarray | None = None,
    ) -> tuple[Scene, float]:
        """Return a scene about a fit to its samples, and the noise of that [m]."""
        fit = self.fit(scene.samples.thinned(ABOUT, FEW), start=start)
        about = replace(scene, x=fit.x, centres=fit.centres, R=fit.R)
        return about, fit.noise


def _begun(
    samples: SeatSamples,
    points: np.ndarray,
    x: np.ndarray,
) -> _State:
    """Return the state at which a fit begins, by balls for its first unknowns."""
    R = samples.robustly_aligned(points)
    places = points - samples.offsets(R)
    centres = medians(places, samples)
    noise = float(typical(places - centres[samples.sockets]))
    return _State(x, R, centres, noise)


def _result(
    samples: SeatSamples,
    points: np.ndarray,
    state: _State,
) -> RigidFit:
    """Return a fit by all samples, once a part of them settled it."""
    places = points - samples.offsets(state.R)
    errors = places - state.centres[samples.sockets]
    weights = robust_weights(errors, state.noise)
    centres = means(places, samples, weights)
    errors = places - centres[samples.sockets]
    distances = np.linalg.norm(errors, axis=1)
    weights = robust_weights(errors, state.noise)
    mean = float(np.average(distances, weights=weights))
    return RigidFit(state.x, state.R, centres, state.noise, distances, mean)

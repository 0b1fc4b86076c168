"""The prior of an arm in a partial fit: the posterior of its calibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..calibration import Calibration, UsageError, posterior_of
from ..design import ParameterCovariance, Workspace
from ..identification.data import STANDARD_LOAD, HandEye, Load, Samples, hand_eye
from ..identification.effects import JOINT_OFFSET
from ..identification.model import ExtendedModel, Noise, block_matrix, extend
from ..identification.robot import (
    Parameter,
    Robot,
    RotationNumbers,
    all_parameters,
    choose_parameters,
    matrix_rpy,
)

LENGTH, ANGLE = 2e-4, 7e-4
"""Tolerances of the lengths [m] and angles [rad] of an arm as made, standard deviations."""
TOLERANCES = {1.0: 0.5, 3.0: 0.25, 10.0: 0.125, 30.0: 0.125}
"""Factors on them, for arms that are less exact, and the prior probability of each."""
UNKNOWN_BALL = 0.1
"""Standard deviation of the ball's place on a nominal arm [m]."""
NOMINAL_NOISE = Noise(1e-4, 1e-3)
"""Noise of an arm that was never calibrated."""
ZERO = 0.2
"""Prior standard deviation of a joint's zero that is estimated [rad], [m]."""
POOLED = 40
"""Poses of each socket by which it is decided which zeros are identifiable."""
IDENTIFIABLE = 1e-3
"""Standard deviation after these, up to which a zero is identifiable [rad], [m]."""
SOCKET = "{}:{}"
"""Name of a socket: its placement, and its number."""


class Flanges(NamedTuple):
    """Poses of the flange, and their derivatives."""

    R: np.ndarray
    """Rotations, shape (N, 3, 3)."""
    p: np.ndarray
    """Shape (N, 3) [m]."""
    by_unknowns: np.ndarray
    """Derivatives of p, then turns, by the model's unknowns, the tool left out, (N, 6, size)."""
    by_joints: np.ndarray
    """The same by the joints' positions, as noisy as each is, shape (N, 6, m)."""

    def hand_eye(self, M: np.ndarray, where: str = "poses") -> HandEye:
        """Return :func:`.hand_eye` of poses M that were measured, shape (N, 4, 4) [m]."""
        return hand_eye(self.R, self.p, M[:, :3, :3], M[:, :3, 3], where)


@dataclass(frozen=True)
class ArmPrior:
    """Mean and covariance of an arm's unknowns, and of the sockets that it was calibrated at."""

    model: ExtendedModel
    """Its unknowns: the geometry, the ball's place among it, the zeros, and all other effects."""
    mean: np.ndarray
    """Of the model's unknowns, then of the sockets' centres in the base, shape (n,)."""
    covariance: np.ndarray
    """Shape (n, n)."""
    sockets: Mapping[str, int]
    """Place of each socket's centre among the unknowns, by :data:`SOCKET`."""
    load: Load
    noise: Noise
    """Noise of its samples in sockets."""

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.model.robot

    @cached_property
    def ball(self) -> np.ndarray:
        """Indices of the unknowns of the ball's, or a tool's, place on the flange, shape (3,)."""
        parameters = self.model.parameters
        return np.array(
            [i for i, p in enumerate(parameters) if p.of_ball and p.unit == "m"]
        )

    @cached_property
    def zeros(self) -> np.ndarray:
        """Index of the unknown of each joint's zero, shape (m,)."""
        return np.arange(self.model.size)[self.model.slices[0]]

    def tolerating(self, factor: float) -> "ArmPrior":
        """Return the prior of an arm whose parts are less exact by a factor, but for the ball."""
        factors = np.full(len(self.mean), factor)
        factors[self.ball] = 1.0
        return replace(self, covariance=self.covariance * np.outer(factors, factors))

    def tip(self, x: np.ndarray) -> np.ndarray:
        """Return the ball's, or a tool's, place on the flange by the unknowns x, shape (3,) [m]."""
        return x[self.ball] + self.model.ball.nominal[self.ball]

    def flanges(self, x: np.ndarray, samples: Samples) -> Flanges:
        """Return the flange's poses by the unknowns x: those of a ball in its origin."""
        model = self.model
        y = x[: model.size].copy()
        y[self.ball] = -model.ball.nominal[self.ball]
        p, p_by_unknowns, p_by_joints = model.linearise(y, samples)
        R, R_by_unknowns, R_by_joints = model.linearise(y, samples, of_turns=True)
        by_unknowns = np.hstack([p_by_unknowns, R_by_unknowns])
        by_joints = np.hstack([p_by_joints, R_by_joints])
        of_tool = [
            i for i, parameter in enumerate(model.parameters) if parameter.of_ball
        ]
        by_unknowns[:, :, of_tool] = 0.0
        origins = model.ball.origins(model.values(y))
        of_ball = matrix_rpy(origins[-1, 3:])
        return Flanges(R @ of_ball.T, p, by_unknowns, by_joints)


def prior_of(arm: Calibration | Robot) -> ArmPrior:
    """Return the prior of an arm: its calibration's posterior, or a nominal model's tolerances."""
    if isinstance(arm, Robot):
        return _nominal_prior(arm)
    if not isinstance(arm, Calibration):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise UsageError(
            "one robot's calibration is needed: of several pick one, as arms[NAME]"
        )
    posterior = posterior_of(arm.document, arm.source)
    fitted = posterior.model
    model = _model(
        fitted.robot, fitted.parameters, fitted.extensions, fitted.ball.rotation_numbers
    )
    sockets = {
        SOCKET.format(*label): model.size + 3 * i
        for i, label in enumerate(posterior.data.labels)
    }
    n = model.size + 3 * len(sockets)
    of_model = [model.names.index(name) for name in fitted.names]
    into = np.array([*of_model, *range(model.size, n)], dtype=np.int64)
    count = len(into)
    mean = np.zeros(n)
    mean[into] = np.concatenate([posterior.x, posterior.centres.ravel()])
    block = posterior.covariance[:count, :count]
    covariance = block_matrix(n, [(into, block)])
    prior = ArmPrior(
        model, mean, covariance, sockets, arm.calibrated.load, posterior.noise
    )
    for zero in arm.document.later_zeros:
        i = prior.zeros[model.robot.joint_names.index(zero.joint)]
        mean[i] += zero.offset
        if zero.offset:
            covariance[i, i] += zero.standard_deviation**2
    return prior


def _nominal_prior(robot: Robot) -> ArmPrior:
    """Return the prior of an arm that was never calibrated, by the tolerances of its parts."""
    model = _model(robot, choose_parameters(robot), ())
    widths = np.zeros(model.size)
    for i, parameter in enumerate(model.parameters):
        widths[i] = LENGTH if parameter.unit == "m" else ANGLE
        if parameter.of_ball:
            widths[i] = UNKNOWN_BALL
    mean, covariance = np.zeros(model.size), np.diag(widths**2)
    return ArmPrior(model, mean, covariance, {}, STANDARD_LOAD, NOMINAL_NOISE)


def _model(
    robot: Robot,
    free: Sequence[Parameter],
    extensions: tuple[str, ...],
    rotation_numbers: RotationNumbers = "vector",
) -> ExtendedModel:
    """Return a model with some parameters free, the ball's place and the zeros in any case."""
    names = {p.name for p in free}
    parameters = [
        p
        for p in all_parameters(robot)
        if p.name in names or (p.of_ball and p.unit == "m")
    ]
    return extend(robot, parameters, (JOINT_OFFSET.name, *extensions), rotation_numbers)


def zero_covariance(arm: Calibration | Robot, sockets: int = 2) -> ParameterCovariance:
    """Return the covariance of an arm whose zeros are lost, before the first sample in a socket."""
    prior = prior_of(arm)
    size = prior.model.size
    covariance = prior.covariance[:size, :size].copy()
    covariance[prior.zeros, prior.zeros] += ZERO**2
    state = ParameterCovariance(prior.model, prior.mean[:size], prior.noise, covariance)
    return state.with_sockets(sockets)


def identifiable_zeros(
    state: ParameterCovariance, pools: Mapping[int, np.ndarray]
) -> Workspace:
    """Return the zeros that samples in sockets can identify, in place of workspace distances.

    Args:
        state: The covariance before the samples.
        pools: For each socket, poses that reach it, shape (N, m).
    """
    zeros = np.eye(state.model.size)[state.model.slices[0]]
    for k, q in pools.items():
        state = state.with_samples(q[:POOLED], k)
    where = Workspace(zeros, np.zeros(len(zeros)))
    identifiable = state.deviations(where) < IDENTIFIABLE
    return Workspace(zeros[identifiable], where.lengths[identifiable])

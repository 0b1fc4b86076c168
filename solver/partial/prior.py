"""The prior of an arm in a partial fit: the posterior of its calibration."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..bayes.model import ExtendedModel, Noise, block_matrix, extend
from ..bayes.model.effects import JOINT_OFFSET
from ..calibration import Calibration, UsageError, posterior_of
from ..data import STANDARD_LOAD, Load
from ..design import ParameterCovariance, Workspace
from ..robot import Robot, RotationNumbers, all_parameters, choose_parameters

LENGTH, ANGLE = 2e-4, 7e-4
"""Tolerances of the lengths [m] and angles [rad] of an arm as made, standard deviations."""
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
        return np.array([i for i, p in enumerate(parameters) if p.of_ball and p.unit == "m"])

    @cached_property
    def zeros(self) -> slice:
        """Indices of the unknowns of the joints' zeros."""
        return self.model.slices[0]


def prior_of(arm: Calibration | Robot) -> ArmPrior:
    """Return the prior of an arm: its calibration's posterior, or a nominal model's tolerances."""
    if isinstance(arm, Robot):
        model = _model(arm, [p.name for p in choose_parameters(arm)], ())
        widths = [
            UNKNOWN_BALL if p.of_ball else LENGTH if p.unit == "m" else ANGLE
            for p in model.parameters
        ]
        wide = np.diag(np.concatenate([widths, np.zeros(model.size - len(widths))]) ** 2)
        return ArmPrior(model, np.zeros(model.size), wide, {}, STANDARD_LOAD, NOMINAL_NOISE)
    if not isinstance(arm, Calibration):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise UsageError("one robot's calibration is needed: of several pick one, as arms[NAME]")
    document = arm.document
    posterior = posterior_of(document, arm.source)
    fit_model = posterior.model
    names = [p.name for p in fit_model.parameters]
    model = _model(fit_model.robot, names, fit_model.extensions, fit_model.ball.rotation_numbers)
    labels = [SOCKET.format(*label) for label in posterior.data.labels]
    places = {label: model.size + 3 * i for i, label in enumerate(labels)}
    n, size = model.size + 3 * len(places), fit_model.size + 3 * len(places)
    into = np.array([model.names.index(name) for name in fit_model.names], dtype=np.int64)
    into = np.concatenate([into, np.arange(model.size, n)])
    mean = np.zeros(n)
    mean[into] = np.concatenate([posterior.x, posterior.centres.ravel()])
    covariance = block_matrix(n, [(into, posterior.covariance[:size, :size])])
    for zero in document.later_zeros:
        i = model.slices[0].start + model.robot.joint_names.index(zero.joint)
        mean[i] += zero.offset
        covariance[i, i] += zero.standard_deviation**2 if zero.offset else 0.0
    return ArmPrior(model, mean, covariance, places, arm.calibrated.load, posterior.noise)


def _model(
    robot: Robot,
    names: list[str],
    extensions: tuple[str, ...],
    rotation_numbers: RotationNumbers = "vector",
) -> ExtendedModel:
    """Return a model with some parameters free, the ball's place and the zeros in any case."""
    parameters = [
        p for p in all_parameters(robot) if p.name in names or (p.of_ball and p.unit == "m")
    ]
    return extend(robot, parameters, (JOINT_OFFSET.name, *extensions), rotation_numbers)


def zero_covariance(arm: Calibration | Robot, sockets: int = 2) -> ParameterCovariance:
    """Return the covariance of an arm whose zeros are lost, before the first sample in a socket."""
    prior = prior_of(arm)
    size = prior.model.size
    covariance = prior.covariance[:size, :size].copy()
    covariance.ravel()[:: size + 1][prior.zeros] += ZERO**2
    state = ParameterCovariance(prior.model, prior.mean[:size], prior.noise, covariance)
    return state.with_sockets(sockets)


def identifiable_zeros(state: ParameterCovariance, pools: Mapping[int, np.ndarray]) -> Workspace:
    """Return the zeros that samples in sockets can identify, in place of workspace distances.

    Args:
        state: The covariance before the samples.
        pools: For each socket, poses that reach it, shape (N, m).
    """
    zeros: np.ndarray = np.eye(state.model.size)[state.model.slices[0]]
    for k, q in pools.items():
        state = state.with_samples(q[:POOLED], k)
    identifiable = state.deviations(Workspace(zeros, np.zeros(len(zeros)))) < IDENTIFIABLE
    return Workspace(zeros[identifiable], np.zeros(int(identifiable.sum())))

"""The result of the default method: the most probable unknowns, and how well they are known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...data import IDENTITY, MultiRobotObservations, Observations, Pose
from ..model import (
    Deflection,
    ExtendedModel,
    Gaussian,
    Kind,
    Noise,
    PriorGroup,
    check,
    prior_covariance,
    submatrix,
)
from ..model.effects import CURVE
from .objective import Objective
from .state import State


@dataclass(frozen=True, eq=False)
class Posterior:
    """The posterior of one robot's unknowns, as a Gaussian."""

    model: ExtendedModel
    data: Observations
    x: np.ndarray
    """The most probable unknowns: changes of the geometry from nominal, then the extensions'
    coefficients, shape (model.size,)."""
    centres: np.ndarray
    """Socket centres in the robot's base, shape (S, 3) [m]."""
    covariance: np.ndarray
    """Covariance of x and the centres, in the robot's base as well, (size + 3 S, size + 3 S)."""
    groups: tuple[PriorGroup, ...]
    """The priors, with the widths that the data gave them."""
    noises: Mapping[Kind, Noise]
    """Noise of each kind of samples."""
    points: np.ndarray
    """Ball centres of the samples, shape (N, 3) [m]."""
    weights: np.ndarray
    """Robust weight of each sample, shape (N,): near 1, and towards 0 far from its socket."""
    log_evidence: float
    """Logarithm of the evidence: how probable the data are under the model, averaged over all
    values that the prior allows for its unknowns."""
    iterates: tuple[np.ndarray, ...]
    """x after each iteration, the start first."""
    moved: np.ndarray | None = None
    """How far the place of each sample has moved, in the robot's base, shape (N, 3) [m]; None for
    places that stood still."""

    def __post_init__(self) -> None:
        check(self.covariance)

    @property
    def noise(self) -> Noise:
        """Noise of samples in sockets, or, where there is none, of measured balls."""
        return self.noises.get("sockets") or self.noises["points"]

    @property
    def active(self) -> tuple[str, ...]:
        """Names of its groups that are not held at zero, but curves."""
        return tuple(g.name for g in self.groups if g.width and g.name != CURVE.name)

    @property
    def prior_covariance(self) -> np.ndarray:
        """Prior covariance of the model's unknowns but error curves, shape (scalars, scalars)."""
        groups = [group for group in self.groups if group.length is None]
        return prior_covariance(groups, self.model.scalars, widened=True)

    @property
    def values(self) -> np.ndarray:
        """The geometric parameters, shape (geometry,) [m, rad]."""
        return self.model.values(self.x)

    @property
    def deflection(self) -> Deflection:
        """The calibrated elasticity and transmission errors."""
        return self.model.deflection(self.x)

    @property
    def residuals(self) -> np.ndarray:
        """Predicted ball centre minus its socket's, of samples in sockets, shape (N, 3) [m]."""
        in_socket = self.data.sockets >= 0
        offsets = self.points if self.moved is None else self.points - self.moved
        return offsets[in_socket] - self.centres[self.data.sockets[in_socket]]

    def predict(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the ball's centre for rows of joint positions and torques, shape (N, 3) [m]."""
        return self.model.predict(self.x, q, torque)


@dataclass(frozen=True, eq=False)
class JointPosterior:
    """The posterior of all robots of a fit, and of the frames that they stand in."""

    state: State
    """The most probable unknowns, or their mean, with the widths and noises that were found."""
    around: Gaussian
    """All unknowns but error curves, movements included, as changes from the state."""
    weights: np.ndarray
    """See :attr:`Posterior.weights`."""
    log_evidence: float
    """See :attr:`Posterior.log_evidence`."""
    iterates: Sequence[np.ndarray]
    """x of all robots and movements after each iteration."""
    with_curves: np.ndarray | None = None
    """Covariance of all unknowns where there are error curves: they are too many for a root."""

    def __post_init__(self) -> None:
        check(self.whole)

    @property
    def whole(self) -> np.ndarray:
        """Covariance of all unknowns, movements and error curves included."""
        return self.around.covariance if self.with_curves is None else self.with_curves

    @property
    def objective(self) -> Objective:
        """Function that was minimised."""
        return self.state.objective

    @cached_property
    def arms(self) -> tuple[Posterior, ...]:
        """Each robot, in its own base."""
        return tuple(map(self._arm, range(len(self.own))))

    @property
    def own(self) -> tuple[slice, ...]:
        """For each robot, which unknowns are its own."""
        return self.objective.own

    @property
    def models(self) -> tuple[ExtendedModel, ...]:
        """The models of the robots."""
        return self.objective.models

    @property
    def scene(self) -> MultiRobotObservations:
        """All observations."""
        return self.objective.rows.scene

    @property
    def frames(self) -> dict[str, Pose]:
        """Pose of each frame in the base of the first robot."""
        return dict(zip(self.scene.arms[0].frames, self.state.frames, strict=True))

    @property
    def bases(self) -> list[Pose]:
        """Pose of each robot's base in that of the first."""
        poses = (self.objective.rows.base(i, self.state.frames) for i in range(len(self.own)))
        return [pose or IDENTITY for pose in poses]

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of x of each robot, the frames, and the socket centres.

        Of a frame there is a turn about the world's axes [rad], then a shift [m].
        """
        if not self.objective.movements:
            return self.whole
        indices = np.r_[: self.own[-1].stop, self.objective.model_size : len(self.whole)]
        return submatrix(self.whole, indices)

    @cached_property
    def active(self) -> tuple[tuple[str, ...], ...]:
        """For each robot, :attr:`Posterior.active`."""
        return tuple(arm.active for arm in self.arms)

    def frame_covariance(self, frame: str) -> np.ndarray:
        """Return the covariance of a frame's pose, its turn [rad] first, shape (6, 6)."""
        begin = self.own[-1].stop + 6 * list(self.frames).index(frame)
        return self.covariance[begin : begin + 6, begin : begin + 6]

    def _arm(self, robot: int) -> Posterior:
        objective, state, members = self.objective, self.state, self.own[robot]
        rows, base = objective.rows.own[robot], objective.rows.base(robot, state.frames)
        centres = state.centres if base is None else base.inverse().apply(state.centres)
        mine = [g for g in state.groups if members.start <= g.members[0] < members.stop]
        kinds = zip(objective.rows.source_kinds, state.noises, strict=True)
        noises: dict[Kind, Noise] = {kind: noise for (i, kind), noise in kinds if i == robot}
        shifts = objective.moved_places(state.x)[rows] if objective.movements else None
        if shifts is not None and base is not None:
            shifts = shifts @ base.rotation
        return Posterior(
            self.models[robot],
            self.scene.arms[robot],
            state.x[members],
            centres,
            self._covariance_in_base(robot, centres),
            tuple(replace(g, members=g.members - members.start) for g in mine),
            noises,
            state.linear.points[rows],
            self.weights[rows],
            self.log_evidence,
            tuple(x[members] for x in self.iterates),
            shifts,
        )

    def _covariance_in_base(self, robot: int, centres: np.ndarray) -> np.ndarray:
        if self.with_curves is not None:
            return self._in_base(robot, centres, self._in_base(robot, centres, self.whole).T)
        root = self._in_base(robot, centres, self.around.root)
        return root @ root.T

    def _in_base(self, robot: int, centres: np.ndarray, changes: np.ndarray) -> np.ndarray:
        """Return changes of a robot's x and of the centres in its base, by those of all unknowns.

        They have shape (n, k); a change of the base shifts the centres of sockets that stand.
        """
        objective, base = self.objective, self.objective.rows.base(robot, self.state.frames)
        of_x, of_centres = changes[self.own[robot]], changes[objective.dense : objective.size]
        if base is not None:
            of_base = changes[objective.of_frame(self.scene.bases[robot])]
            shifted = of_centres.reshape(-1, 3, changes.shape[1]) - base.slopes(centres) @ of_base
            of_centres = (base.rotation.T @ shifted).reshape(of_centres.shape)
        return np.concatenate([of_x, of_centres])

"""The result of the default method: the most probable unknowns, and how well they are known."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...data import MultiRobotObservations, Observations, Pose
from ..model import Deflection, ExtendedModel, Kind, Movement, Noise, PriorGroup, SampleRows


@dataclass(frozen=True)
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
    """Covariance of x and the centres, shape (size + 3 S, size + 3 S)."""
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

    @property
    def noise(self) -> Noise:
        """Noise of samples in sockets, or, where there is none, of measured balls."""
        return self.noises.get("sockets") or self.noises["points"]

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
        seated = self.data.sockets >= 0
        off = self.points if self.moved is None else self.points - self.moved
        return off[seated] - self.centres[self.data.sockets[seated]]

    def predict(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the ball's centre for rows of joint positions and torques, shape (N, 3) [m]."""
        return self.model.predict(self.x, q, torque)


@dataclass(frozen=True)
class JointPosterior:
    """The posterior of all robots of a fit, and of the frames that they stand in."""

    arms: tuple[Posterior, ...]
    """Each robot, in its own base."""
    own: tuple[slice, ...]
    """For each robot, which unknowns are its own."""
    scene: MultiRobotObservations
    """All observations."""
    frames: dict[str, Pose]
    """Pose of each frame in the base of the first robot."""
    covariance: np.ndarray
    """Of all unknowns: x of each robot, the frames (a turn about the world's axes [rad], then a
    shift [m]), the socket centres."""
    log_evidence: float
    """See :attr:`Posterior.log_evidence`."""

    movements: tuple[tuple[Movement, np.ndarray, PriorGroup], ...] = ()
    """How placements moved while they were recorded: with the unknowns, and their prior."""

    def noises_of(self, rows: SampleRows) -> tuple[Noise, ...]:
        """Return the noise of each source of samples of the same robots."""
        return tuple(self.arms[i].noises.get(k) or self.arms[i].noise for i, k in rows.source_kinds)

    def frame_covariance(self, frame: str) -> np.ndarray:
        """Return the covariance of a frame's pose, its turn [rad] first, shape (6, 6).

        Where priors have shrunk to nothing, rounding may leave a variance below zero: it is none.
        """
        begin = self.own[-1].stop + 6 * list(self.frames).index(frame)
        block = self.covariance[begin : begin + 6, begin : begin + 6]
        values, vectors = np.linalg.eigh((block + block.T) / 2)
        return (vectors * values.clip(min=0)) @ vectors.T

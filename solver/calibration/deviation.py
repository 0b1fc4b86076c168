"""Covariance of the poses of a calibrated robot."""

from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .. import results
from ..identification.data import measure
from ..identification.inference import Posterior
from ..identification.robot import workspace
from ..studies import (
    HeldOut,
    misfit,
    movement_covariances,
    pose_covariances,
    tail,
    unit,
)
from .earlier import posterior_of
from .full_model import FullModel
from .poses import checked

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .poses import Setup

POSES_AROUND = 60
"""Poses in the workspace, by which an error of the whole arm is told from those of movements."""


class FittedModel(FullModel):
    """A calibrated robot, and the document of the fit that it is by.

    Args:
        document: All that ``calibration.json`` holds.
        calibrated: The calibrated robot; None to build it from the document.
        source: The document's file, for messages.
    """

    def __init__(
        self,
        document: results.CalibrationDocument,
        calibrated: results.CalibratedRobot | None = None,
        source: str = "calibration",
    ) -> None:
        super().__init__(calibrated or results.calibrated_robot(document, source))
        self.document = document
        """Everything, as ``calibration.json`` holds it."""
        self.source = source
        """Its file, for messages."""

    @cached_property
    def posterior(self) -> Posterior:
        """The robot's unknowns and their covariance."""
        return posterior_of(self.document, self.source)

    @cached_property
    def misfit(self) -> float:
        """Error of held-out samples beyond the posterior, in units of the noise of the fit.

        A root mean square. Where folds left samples out, of these. 0 without such samples, or too
        few.
        """
        stored = self.document.misfit
        return misfit(self._unseen) if stored is None else stored

    @cached_property
    def tail(self) -> float:
        """Factor t on 95 % of a normal distribution that left-out samples need, 1 or more.

        95 of 100 are within t times the 95 % of :meth:`deviation`. Real errors have a tail.
        """
        stored = self.document.tail
        return tail(self._unseen) if stored is None else stored

    @cached_property
    def _unseen(self) -> list[tuple[Posterior, HeldOut]]:
        robot, load = self.robot, self.load
        places: list[HeldOut] = []
        for row in self.document.data:
            if row.role == "test":
                recorded = row.placement(robot.joint_names)
                held = measure(recorded, robot, sockets=1, load=load)
                places += HeldOut.of(robot, load, held)
        return [(self.posterior, place) for place in places]

    def deviation(
        self,
        q: ArrayLike,
        *,
        relative_to: ArrayLike | None = None,
        **setup: "Unpack[Setup]",
    ) -> np.ndarray:
        """Return how well :meth:`flange` is known: covariances of poses, shape (..., 6, 6).

        Rows and columns are the place [m], then the turn about the axes of the frame in which poses
        are given [rad]. The setup itself counts as exact. Where the calibration has held-out
        samples, what they miss beyond the posterior is in it, see :attr:`misfit`: errors that the
        model lacks, the encoders' noise, and that of what measured them. One deviation is a root
        mean square; :attr:`tail` says how much more than normal errors reach far.

        Sockets do not show where the base stands, so places in it are known to millimetres.
        A movement ``relative_to`` another pose is known far better, see
        :func:`.movement_covariances`.

        Args:
            q: Joint positions as the encoders read them, shape (..., m) [rad].
            relative_to: Joint positions from which the arm moves to ``q``, shape (m,) [rad]; the
                covariance is that of the movement, by the same axes.
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
            UsageError: A calibration by the paper's method, which has no covariance.
        """
        arm = self.kinematics(**setup)
        rows = checked(arm.calibrated, q)
        covariances = pose_covariances
        if relative_to is not None:
            rows = np.concatenate([checked(arm.calibrated, relative_to)[:1], rows])
            around = arm.load.at(arm.robot, workspace(arm.robot, POSES_AROUND))
            covariances = partial(movement_covariances, around=around)
        poses = arm.calibrated.poses(rows)[0].reshape(-1, 4, 4) @ arm.tool
        samples = arm.load.at(arm.robot, rows)
        tool = setup.get("tool")
        places = poses[:, :3, 3]
        of_ball = isinstance(tool, str) and tool == self.robot.tip
        inside = covariances(
            self.posterior, samples, places, of_ball=of_ball, misfit=self.misfit
        )
        R = np.kron(np.eye(2), arm.base[:3, :3])
        return (R @ inside @ R.T).reshape(*np.shape(q)[:-1], 6, 6)

    def distance_deviation(
        self, q: ArrayLike, start: ArrayLike, **setup: "Unpack[Setup]"
    ) -> np.ndarray:
        """Return how well distances from one place to others are known, shape (...) [m].

        Args:
            q: Joint positions at the other places, shape (..., m) [rad].
            start: Joint positions at the one place, shape (m,) [rad].
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            JointsError, UsageError: As :meth:`deviation`.
        """
        C = self.deviation(q, relative_to=start, **setup)[..., :3, :3]
        ways = self.flange(q, **setup) - self.flange(start, **setup)
        u = unit(ways[..., :3, 3])
        return np.einsum("...i,...ij,...j->...", u, C, u) ** 0.5

"""Covariance of the poses of a calibrated robot."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .. import results
from ..identification.data import measure
from ..identification.inference import Posterior
from ..studies import HeldOut, misfit, pose_covariances
from .earlier import posterior_of
from .full_model import FullModel
from .poses import checked

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .poses import Setup


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

        Where folds left samples out, of these. 0 without such samples, or too few.
        """
        if self.document.misfit is not None:
            return self.document.misfit
        robot, load, names = self.robot, self.calibrated.load, self.robot.joint_names
        places: list[HeldOut] = []
        for row in self.document.data:
            if row.role == "test":
                held = measure(row.placement(names), robot, sockets=1, load=load)
                places += HeldOut.of(robot, load, held)
        return misfit([(self.posterior, place) for place in places])

    def deviation(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return how well :meth:`flange` is known: covariances of poses, shape (..., 6, 6).

        Rows and columns are the place [m], then the turn about the axes of the frame in which poses
        are given [rad]. The setup itself counts as exact. Where the calibration has held-out
        samples, what they miss beyond the posterior is in it, see :attr:`misfit`: errors that the
        model lacks, the encoders' noise, and that of what measured them.

        Args:
            q: Joint positions as the encoders read them, shape (..., m) [rad].
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
            UsageError: A calibration by the paper's method, which has no covariance.
        """
        arm = self.kinematics(**setup)
        rows = checked(arm.calibrated, q)
        poses = arm.calibrated.poses(rows)[0].reshape(-1, 4, 4) @ arm.tool
        samples = arm.load.at(arm.robot, rows)
        tool = setup.get("tool")
        places = poses[:, :3, 3]
        of_ball = isinstance(tool, str) and tool == self.robot.tip
        inside = pose_covariances(
            self.posterior, samples, places, of_ball=of_ball, misfit=self.misfit
        )
        R = np.kron(np.eye(2), arm.base[:3, :3])
        return (R @ inside @ R.T).reshape(*np.shape(q)[:-1], 6, 6)

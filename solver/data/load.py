"""The load on an arm at rest: gravity, and a payload at the ball."""

from dataclasses import dataclass

import numpy as np

from ..robot import STANDARD_GRAVITY, Robot, gravity_moments
from .measurements import Measurement


@dataclass(frozen=True)
class Load:
    """Gravity, and a payload at the ball."""

    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    """In the base frame [m/s^2]; another direction for an arm on a wall or ceiling."""
    payload: float = 0.0
    """Mass at the ball, beyond that of the model [kg]."""

    def torques(self, robot: Robot, measured: Measurement) -> np.ndarray:
        """Return the moments that hold the joints in a placement's samples; see :meth:`moments`."""
        return self.moments(robot, measured.positions, measured.efforts)

    def by_socket(self, robot: Robot, measured: Measurement) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return joint positions and :meth:`torques` of the samples in each socket."""
        moments = self.torques(robot, measured)
        return [(measured.positions[rows], moments[rows]) for rows in measured.slices]

    def moments(self, robot: Robot, q: np.ndarray, efforts: np.ndarray | None) -> np.ndarray:
        """Return the moments that hold the joints of an arm.

        Args:
            robot: The robot.
            q: Joint positions, shape (N, m) [rad].
            efforts: Torques as measured, shape (N, m) [N m]; None for those of the model's masses.

        Returns:
            Shape (N, 3 m) [N m]: torques about the joints' own axes, then the moments across them,
            which always follow from the masses.
        """
        moments = gravity_moments(robot, q, self.gravity, self.payload)
        if efforts is not None:
            moments[:, : q.shape[1]] = efforts
        return moments

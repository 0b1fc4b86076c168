"""A calibrated robot at samples: where its ball is, and where its joints truly are."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..identification.data import Load
from ..identification.robot import Robot
from ..results import CalibratedRobot, Payload, PosedRobot
from .poses import checked


class SampleModel:
    """A calibrated robot, which predicts what its samples show.

    Args:
        calibrated: The calibrated robot, which carries its payload.
    """

    def __init__(self, calibrated: CalibratedRobot) -> None:
        self.calibrated = PosedRobot.of(calibrated)
        """The calibrated robot: predictions and URDFs."""

    def __getstate__(self) -> dict[str, Any]:
        """Go to other processes without what can be computed again."""
        return {
            name: value
            for name, value in vars(self).items()
            if not isinstance(getattr(type(self), name, None), cached_property)
        }

    @cached_property
    def _loaded(self) -> Callable[[Payload | None], CalibratedRobot]:
        """The robot by the payload that it carries."""
        return lru_cache(maxsize=8)(self.calibrated.carrying)

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibrated.robot

    @property
    def load(self) -> Load:
        """Gravity [m/s^2] and payload at the ball [kg] that it was recorded with."""
        return self.calibrated.load

    def ball(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return where the calibrated robot has the ball's centre, in its base frame [m].

        Args and errors are those of :meth:`.CalibratedRobot.ball`.
        """
        points = self.calibrated.ball(q, effort)
        checked(self.calibrated, q)
        return points

    def true_positions(
        self, q: ArrayLike, effort: ArrayLike | None = None
    ) -> np.ndarray:
        """Return where the joints truly are while their encoders read q [rad].

        Args, shapes and errors are those of :meth:`ball`; shape (m,) or (N, m).
        """
        positions = self.calibrated.true_positions(q, effort)
        checked(self.calibrated, q)
        return positions

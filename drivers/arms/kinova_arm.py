"""A connection to a Kinova arm of any generation, which is asked for its joints."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

Answers = tuple[Sequence[float], Sequence[float]]
"""Angles [degrees] and torques [N m] of all joints, from base to flange, by the arm's own sign."""


class KinovaArm(ABC):
    """A connection that is asked for the joints again and again."""

    joints: int
    """Number of the arm's joints."""
    sign: int
    """1, or -1 where the torques have the opposite sign of what a state needs."""
    rate: float
    """Rate at which to ask [Hz]."""
    centred: bool = False
    """True where the first angle of each joint is brought between -180 and 180 degrees."""
    rejected: int = 0
    """Number of answers that could not be used."""

    @abstractmethod
    def measure(self, deadline: float) -> Answers:
        """Ask all joints once; raise SILENT when one does not answer until the deadline [s]."""

    @abstractmethod
    def close(self) -> None:
        """End the connection; safe to call twice."""

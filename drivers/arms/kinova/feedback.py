"""What the ways to ask a Kinova arm have in common: joint angles and torques, on request."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Measurement:
    """What an arm answers: one number for each joint, from base to flange."""

    degrees: tuple[float, ...]
    """Joint angles [degrees]."""
    torques: tuple[float, ...]
    """Joint torques [N m], with the arm's own sign."""


class KinovaArm(Protocol):
    """A connection that is asked for the joints again and again."""

    joints: int
    """How many joints the arm has."""
    sign: int
    """1, or -1 where the torques have the opposite sign of what a state needs."""
    rate: float
    """How often to ask [Hz]."""
    centred: bool
    """Whether the first angle of each joint is brought between -180 and 180 degrees."""
    rejected: int
    """Answers that could not be used."""

    def measure(self, deadline: float) -> Measurement:
        """Ask all joints once.

        Args:
            deadline: When to give up, by the host's monotonic clock [s].

        Raises:
            DriverError: SILENT when a joint does not answer in time.
        """
        ...

    def close(self) -> None:
        """End the connection; safe to call twice."""
        ...

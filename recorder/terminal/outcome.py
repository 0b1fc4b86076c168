"""Outcome of a session at one placement."""

from dataclasses import dataclass

from ..session import Advice, Recording, Session


@dataclass(frozen=True)
class Outcome:
    """End of a session."""

    session: Session
    signal: int | None
    """The signal that ended it; None where the operator did."""
    refused: int
    """Number of refused captures."""
    successor: Recording | None = None
    """The next placement, open, if the operator goes on there."""
    advice: Advice | None = None
    """The last that was given."""

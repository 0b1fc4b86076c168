"""Outcome of a session at one placement."""

from dataclasses import dataclass

from .. import Sample
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
    moved: tuple[Sample, ...] = ()
    """Samples that belong to it."""
    advice: Advice | None = None
    """The last that was given."""

    @property
    def new_placement(self) -> bool:
        """True if the operator goes on at a new placement."""
        return self.successor is not None

    @property
    def readings_changed(self) -> bool:
        """True if joints read otherwise since: earlier placements tell nothing of the new one."""
        return bool(self.successor and self.successor.metadata.readings_changed)

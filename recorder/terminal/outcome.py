"""Outcome of a session at one placement."""

from dataclasses import dataclass

from .. import Sample
from ..session import Advice, Session


@dataclass(frozen=True)
class Outcome:
    """End of a session."""

    session: Session
    signal: int | None
    """The signal that ended it; None where the operator did."""
    refused: int
    """Number of refused captures."""
    new_placement: bool = False
    """True if the operator goes on at a new placement."""
    readings_changed: bool = False
    """True if joints read otherwise since: earlier placements tell nothing of the new one."""
    moved: tuple[Sample, ...] = ()
    """Samples that belong to it."""
    advice: Advice | None = None
    """The last that was given."""

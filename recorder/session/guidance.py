"""What a calibration in the background tells the operator, as values; nothing here computes it."""

from dataclasses import dataclass
from typing import Protocol

from .. import Sample

TELLING = 3
"""So many samples tell where the ball is on the arm, which nothing could be predicted without."""


@dataclass(frozen=True)
class Question:
    """What is asked after every change of the session."""

    samples: tuple[Sample, ...]
    """Those that count."""
    socket: int
    """The active one."""
    position: tuple[float, ...] | None
    """Where the arm is [rad], [m] for a prismatic joint."""


@dataclass(frozen=True)
class Advice:
    """How good a calibration on the samples would be now, and what would improve it most."""

    count: int
    """How many samples it rests on."""
    socket: int
    """For which active socket it was given."""
    predicted: float
    """Predicted error of distances in the workspace, the median of one standard deviation [m]."""
    goal: float
    """What it should come to [m]."""
    fitted: bool = False
    """Whether a fit to the samples says so; before there are enough, the nominal model does."""
    last_error: float | None = None
    """How far the last sample lies from its socket's centre by the fit [m]."""
    mean_error: float | None = None
    """The mean of that over all samples [m]."""
    scale: float | None = None
    """By what share the arm came out larger than its model."""
    distance: float | None = None
    """Between the centres of sockets 0 and 1 by the fit [m]."""
    leave: bool = False
    """Whether this socket has enough, and another has not."""
    enough: bool = False
    """Whether the goal is reached, or more samples at this placement would hardly help."""
    target: tuple[float, ...] | None = None
    """The configuration that would improve it most."""
    gain: float = 0.0
    """By what share it would lower the predicted error."""
    doubt: str | None = None
    """What is odd about the samples, in words."""
    closing: tuple[str, ...] = ()
    """What another placement would bring, a line each, once this one is enough."""

    @property
    def telling(self) -> bool:
        """Whether the prediction says anything yet: before, it is where the ball may be."""
        return self.count >= TELLING

    @property
    def why_enough(self) -> str:
        """Why nothing more is needed at this placement; empty where more is."""
        if not self.enough:
            return ""
        reached = self.predicted <= self.goal
        return "the goal is reached" if reached else "more poses here hardly help"


class GuidanceProvider(Protocol):
    """Somebody who works out advice elsewhere, so that the recorder never waits for it."""

    @property
    def trouble(self) -> str | None:
        """Why no advice comes any more; None while it does."""
        ...

    @property
    def idle(self) -> bool:
        """Whether a question can be asked now."""
        ...

    def ask(self, question: Question) -> None:
        """Ask; never waits."""
        ...

    def answer(self) -> Advice | None:
        """Return the newest answer that has come since; None without one."""
        ...

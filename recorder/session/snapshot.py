"""What is known at one moment of a session: all that a screen or a page shows."""

import math
from dataclasses import dataclass

from .guidance import Advice
from .operator_prompt import OperatorPrompt
from .session import Session


@dataclass(frozen=True)
class View:
    """What is known at one moment."""

    session: Session
    title: str
    ready: OperatorPrompt
    """What the operator is to do."""
    position: tuple[float, ...] | None = None
    """Joint positions of the last state that was not faulty [rad], [m]; None before the first."""
    advice: Advice | None = None
    """How good a calibration would be now, and what would improve it."""
    rate: float = 0.0
    """States per second."""
    age: float = math.inf
    """Time since the last state [s]."""
    missed: int = 0
    """States that were lost on the way."""
    drops: int = 0
    """How often the connection was lost."""
    discarded: int = 0
    """Messages that the driver could not use."""
    card: tuple[str, ...] = ()
    """What is continued, while the operator is asked about it."""
    help: bool = False
    """Whether to show the help in place of joints and captures."""
    scripted: bool = False
    """Whether a script presses the keys."""

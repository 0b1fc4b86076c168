"""Answers to the questions of a user in ``report.json``, and the next steps."""

from typing import Literal

from ....solver.assessment import Point
from ....solver.results import Document

Answer = Literal["yes", "mostly", "no", "trained on"]
"""``mostly``: 19 of 20 samples; ``trained on``: its errors prove nothing."""


class Step(Document, kw_only=True, frozen=True):
    """One thing to do next."""

    text: str
    command: str
    """To copy."""
    expected: str = ""
    """Its expected benefit, in words."""
    before: float | None = None
    """The error that it should lower [m]; None, here and below, where it lowers none."""
    after: float | None = None
    """Expected error after the step [m]."""


class UseAtPlacement(Document, kw_only=True, frozen=True):
    """May the arm be used for the task at this placement?"""

    name: str
    called: str
    """Its name, with the robot's side where it is on one."""
    where: str
    answer: Answer


class UseAnswer(Document, kw_only=True, frozen=True):
    """The answer to "May I use this arm for my task?"."""

    rows: tuple[UseAtPlacement, ...]
    text: str
    meaning: str
    """Definition of the error."""
    alone: str | None
    """Error of the exported URDF by itself, where it is not the full model."""
    between: str
    """Accuracy of points that were not taught at the place itself."""
    cannot_see: tuple[str, ...]
    """Quantities that a ball in a socket cannot tell."""


class NextAnswer(Document, kw_only=True, frozen=True):
    """The answer to "Which placement next?"."""

    text: str
    train_on: str | None
    """A placement that is recorded already, and worth training on too."""
    place: Point
    """Position at which to record a new one [m]."""
    joints: tuple[str, ...]
    """Those that hardly moved."""


class WorstSample(Document, kw_only=True, frozen=True):
    """A sample far from its socket."""

    where: str
    """File and line."""
    name: str
    """Of its placement."""
    socket: int
    number: int
    """Its place among the samples of its socket, from 1."""
    weight: float | None
    """Robust weight in the fit; None where there was none."""
    error: float
    """Distance from its socket's centre by the calibrated model [m]."""
    ratio: float
    """That distance over the mean of its placement."""


class LoneFit(Document, kw_only=True, frozen=True):
    """Error of a placement when fitted alone, the figure of ``mukca check``."""

    name: str
    mean_absolute_error: float
    """Mean distance of its samples from their socket, each by its weight [m]."""


class DataAnswer(Document, kw_only=True, frozen=True):
    """The answer to "Is my data all right?"."""

    text: str
    worst: tuple[WorstSample, ...]
    floors: tuple[LoneFit, ...]


class Answers(Document, kw_only=True, frozen=True):
    """The answers to the three questions that a user has."""

    use: UseAnswer
    next: NextAnswer
    data: DataAnswer

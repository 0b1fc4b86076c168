"""The words in ``report.json``: limits and verdict, and the answers to a user's questions."""

from typing import Literal

from ..results import Document

Status = Literal["pass", "warning", "fail", "not enough", "not evaluated"]
"""``warning``: look at it; ``not enough``: too little was recorded to say."""


Outcome = Literal["pass", "fail", "incomplete"]
"""Of a verdict."""


class Limit(Document, kw_only=True, frozen=True):
    """The largest value that passes."""

    value: float | None
    """[m]; None where nothing says what is good for this arm."""
    source: str
    """Where it comes from, or what is needed to have it."""


class Limits(Document, kw_only=True, frozen=True):
    """What a calibration is held against."""

    repeatability: float | None
    """How well the arm comes back to the same place [m], where it is known."""
    repeatability_source: str
    mean_absolute_error: Limit
    distance_error: Limit
    between_placements: Limit


class LimitResult(Document, kw_only=True, frozen=True):
    """One limit of the verdict, and whether it is kept."""

    name: str
    title: str
    found: float | None
    """What ``calibrated.urdf`` reaches [m]."""
    limit: float | None
    """[m]."""
    status: Status
    full: float | None = None
    """What the full model reaches, where ``calibrated.urdf`` is not all of it [m]."""
    full_status: Status | None = None
    text: str
    reason: str
    """Where the limit comes from, or what is missing."""


class Verdict(Document, kw_only=True, frozen=True):
    """Whether ``calibrated.urdf`` keeps its limits."""

    status: Outcome
    title: str
    text: str
    limits: tuple[LimitResult, ...]

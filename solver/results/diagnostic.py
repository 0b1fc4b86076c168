"""Diagnostics of recordings in ``calibration.json``: what was seen, and what explains it."""

from dataclasses import asdict, dataclass
from typing import Any

from .files import Document


@dataclass(frozen=True)
class Diagnostic:
    """One thing that was seen."""

    level: str
    """``error``: do not train on it as it is; ``warning``: look at it."""
    code: str
    where: str
    text: str
    advice: str

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.where}: {self.text}; {self.advice}"


@dataclass(frozen=True)
class Hypothesis:
    """An explanation of the recordings, with its probability."""

    name: str
    """As in the documentation's list of causes; ``sound`` where nothing is wrong."""
    probability: float
    parameters: dict[str, float | str | list[float]]
    """Numbers and names by which it is told: lengths in m, angles in rad, samples from 0."""
    text: str
    advice: str
    tell: str
    """Step that tells it from others."""


class NextPlacement(Document, kw_only=True, frozen=True):
    """Place to record next, in words."""

    text: str

"""Patterns of the errors that a fit leaves: over each joint's angle, reach and height, and time."""

import math

from .files import Document


class ErrorPattern(Document):
    """Errors that a fit leaves over one quantity, with their running mean and its band."""

    over: str
    """A joint's name, ``reach``, ``height`` or ``time``."""
    unit: str
    """Of the quantity: rad, m, or none for the share of a placement's time."""
    along: str
    """Direction of the errors that are drawn, in words."""
    at: tuple[float, ...]
    """The quantity at each sample."""
    errors: tuple[float, ...]
    """Error of each sample along the direction [m]."""
    grid: tuple[float, ...]
    mean: tuple[float, ...]
    """Running mean on the grid [m]."""
    band: tuple[float, ...]
    """Half of the 95 % band of the running mean where nothing but noise is left [m]."""
    size: float
    """Most probable size of the pattern, root mean square at the ball [m]."""
    log_odds: float
    """Logarithm of the odds of the pattern against noise, less that of the number tried."""


class ErrorPatterns(Document):
    """Patterns of the rest of the error."""

    patterns: tuple[ErrorPattern, ...]
    strongest: str | None
    """The pattern that stands out by its evidence; None where none does."""

    @property
    def text(self) -> str:
        """The strongest pattern and its evidence, in a sentence."""
        pattern = next((p for p in self.patterns if p.over == self.strongest), None)
        if pattern is None:
            return (
                "The rest shows no pattern over joints' angles, reach, height or time."
            )
        what = {
            "reach": "the arm's reach",
            "height": "the arm's height",
            "time": "time",
        }
        over = what.get(pattern.over, f"the angle of {pattern.over}")
        odds = pattern.log_odds / math.log(10)
        size = f"{1e3 * pattern.size:.2f} mm (rms)"
        return f"The rest follows {over}: {size}, odds 10^{odds:.0f} to 1."

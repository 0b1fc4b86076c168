"""Worth of a calibration in ``calibration.json``: errors in parts and patterns, gains, outlook."""

import math
from dataclasses import dataclass

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


class Interval(Document):
    """An error of distances [m], with its 68 % interval."""

    value: float
    low: float
    high: float


class ErrorParts(Document):
    """Held-out error in three parts that add in squares: root mean squares over samples [m]."""

    error: float
    """Distance of samples from their socket's mean."""
    noise: float
    """Of the ball's seat and the encoders: it stays."""
    want_of_data: float
    """More samples and placements make it smaller."""
    not_in_model: Interval
    """The other errors, of which the model lacks the cause, with their 95 % interval."""

    @property
    def shares(self) -> tuple[float, float, float]:
        """Shares of the three parts in the mean square, which add to 1."""
        sizes = self.noise, self.want_of_data, self.not_in_model.value
        noise, want, lacking = [size**2 / self.error**2 for size in sizes]
        return noise, want, lacking

    @property
    def text(self) -> str:
        """The parts in words, with the interval of what is not in the model."""
        unmodelled = self.not_in_model
        parts = self.error, self.noise, self.want_of_data
        sizes = *parts, unmodelled.value, unmodelled.low, unmodelled.high
        error, noise, want, lacking, low, high = [f"{1e3 * size:.2f}" for size in sizes]
        return (
            f"Samples not trained on scatter by {error} mm (rms) about their socket, by the full "
            f"model: {noise} is noise, {want} falls with more data, {lacking} is not in the model "
            f"(95 %: {low} to {high}); the parts add in squares."
        )


class Improvement(Document):
    """Errors of distances before a calibration and after it: medians over pairs of poses."""

    before: Interval
    """By the nominal model with its ball refitted, or with the calibrated ball: the smaller."""
    now: Interval
    """By ``calibrated.urdf``."""
    corrected: Interval | None = None
    """With joint positions corrected first; None where that is ``calibrated.urdf``."""
    probability: float
    """Probability that ``calibrated.urdf`` is better than the nominal model."""
    corrected_probability: float | None = None
    """The same with joint positions corrected first."""


class Better(Document):
    """Improvement by a calibration."""

    workspace: Improvement
    """Distances between random poses of the workspace."""
    recorded_places: Improvement | None = None
    """Distances near the recorded places, at the worst of them; None where none is in reach."""

    @property
    def places(self) -> tuple[Improvement, ...]:
        """Those of the workspace, and of the recorded places where there are any."""
        return (self.workspace, *filter(None, [self.recorded_places]))

    @property
    def probability(self) -> float:
        """Probability that ``calibrated.urdf`` is better, where that is the least sure."""
        return min(place.probability for place in self.places)

    @property
    def corrected_probability(self) -> float | None:
        """The same with joint positions corrected first; None where that is no other model."""
        those = [place.corrected_probability for place in self.places]
        return min((p for p in those if p is not None), default=None)


class Apart(Document):
    """Mean distance of the balls of two calibrations, and what chance would make of it [m]."""

    value: float
    """After a rigid motion of the base frame."""
    chance: float
    """Its mean, if the arm is the same and all that the models lack is noise."""
    deviation: float
    """Its standard deviation by chance."""
    largest: float
    """By chance 19 of 20 are not larger."""
    probability: float
    """That chance alone makes it as large."""

    @property
    def beyond_chance(self) -> bool:
        """True if it is larger than 19 of 20 would be by chance."""
        return self.value > self.largest


class Forecast(Document):
    """Gain of another placement, if it were trained on too."""

    placement: str | None
    """Its name; None for one that is not recorded yet, with 2 x 30 varied samples far from all."""
    distance_deviation: float
    """Standard deviation of distances in the workspace that would be left [m]."""
    share: float | None = None
    """Error of distances by ``calibrated.urdf`` that would be left, as a share of that now."""


@dataclass(frozen=True)
class ErrorMap:
    """Predicted errors of places, relative to those that were recorded."""

    width: float
    """Of a square cell [m]."""
    cells: tuple[tuple[float, float, float], ...]
    """For each cell that random poses reach, from above: x and y of its middle in the base frame,
    and the standard deviation of its distance from what was trained on [m]."""


@dataclass(frozen=True)
class JointEffect:
    """Displacement of the ball by a joint's calibrated numbers: root mean square over poses [m]."""

    joint: str
    recorded: float
    """Over the samples that were trained on."""
    workspace: float
    """Over random poses of the workspace."""


class Outlook(Document):
    """Predicted worth of a calibration."""

    joints: tuple[JointEffect, ...]
    """Effect of each joint."""
    map: ErrorMap | None = None
    """None by the paper's method, which does not say."""
    forecasts: tuple[Forecast, ...] = ()

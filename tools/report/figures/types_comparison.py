"""What ``compare.json`` holds: several calibrations of one robot on the same data; in metres."""

from ....solver.assessment import Quantiles
from ....solver.results import Document
from .types_drawing import Displacement

FORMAT = "mukca-comparison-1"


class ErrorsOverall(Quantiles, kw_only=True, frozen=True):
    """A model's errors over all placements that none of the models was trained on."""

    mean_absolute_error: float
    distance_error: float | None
    """Mean of the absolute values; None where no placement has two sockets."""


class ComparedModel(Document, kw_only=True, frozen=True):
    """One of the models: the nominal one, or a calibration."""

    name: str
    summary: ErrorsOverall | None
    """None where every placement was trained on by some model."""


class ErrorsAtPlacement(Document, kw_only=True, frozen=True):
    """A model's errors at one placement."""

    mean_absolute_error: float
    max_error: float
    distance_error: float | None
    """Predicted less measured; None where there is one socket only."""
    quantiles: Quantiles
    trained_on: bool


class ComparedPlacement(Document, kw_only=True, frozen=True):
    """One placement, and the errors of all models there."""

    name: str
    samples: tuple[int, ...]
    """Number of samples in each socket."""
    models: tuple[ErrorsAtPlacement, ...]


class Difference(Document, kw_only=True, frozen=True):
    """By how much the error of one model exceeds that of another."""

    mean: float
    noise: float
    """Half the width of the mean's 95 % interval."""
    beyond_noise: bool


class ComparedPair(Document, kw_only=True, frozen=True):
    """Model b less model a."""

    a: int
    """Index of the model."""
    b: int
    placements: tuple[Difference, ...]
    summary: Difference | None
    """Over the placements that none of the models was trained on; None where there are none."""
    apart: Displacement
    """How far they put the ball apart, after a rigid motion of the base frame is taken out."""


class ComparisonPlot(Document, kw_only=True, frozen=True):
    """A plot of the page, in one sentence."""

    id: str
    title: str
    sentence: str


class ComparisonDocument(Document, kw_only=True, frozen=True):
    """All of ``compare.json``."""

    format: str
    robot_name: str
    models: tuple[ComparedModel, ...]
    """The nominal model first."""
    placements: tuple[ComparedPlacement, ...]
    fair: tuple[int, ...]
    """Indices of the placements that none of the models was trained on."""
    pairs: tuple[ComparedPair, ...]
    """Each model less each one before it in the list."""
    plots: tuple[ComparisonPlot, ...] | None = None
    """Only where a page was written."""

"""All of ``compare.json``: errors of several models of one robot, and how each two differ."""

from dataclasses import dataclass

from ....solver.assessment import Quantiles, joined
from ....solver.identification.data import Metrics
from ....solver.results import Apart, CurveAgreement, Document, agreement_words
from .templates import text
from .types import Displacement, PlotCaption

COMPARISON = "mukca-comparison-1"
NOMINAL = "nominal"
"""Name of the model that no calibration changed."""


class ErrorsOverall(Quantiles):
    """A model's errors over all placements that none of the models was trained on."""

    mean_absolute_error: float
    distance_error: float | None
    """Mean of the absolute values; None where no placement has two sockets."""


class ComparedModel(Document):
    """One of the models: the nominal one, or a calibration."""

    name: str
    summary: ErrorsOverall | None
    """None where every placement was trained on by some model."""
    corrected_joints: bool = False
    """True where its errors are those with corrected joint positions, below those of its URDF."""


@dataclass(frozen=True, kw_only=True)
class ErrorsAtPlacement(Metrics):
    """A model's errors at one placement."""

    quantiles: Quantiles
    trained_on: bool


class ComparedPlacement(Document):
    """One placement, and the errors of all models there."""

    name: str
    samples: tuple[int, ...]
    """Number of samples in each socket."""
    models: tuple[ErrorsAtPlacement, ...]


class Difference(Document):
    """By how much the error of one model exceeds that of another."""

    mean: float
    noise: float
    """Half the width of the mean's 95 % interval."""
    beyond_noise: bool


class ComparedPair(Document):
    """Model b less model a."""

    a: int
    """Index of the model."""
    b: int
    placements: tuple[Difference, ...]
    summary: Difference | None
    """Over the placements that none of the models was trained on; None where there are none."""
    apart: Displacement
    """Of the ball between the two, after a rigid motion of the base frame is taken out."""
    workspace: Apart | None = None
    """Distance of the two at random poses, and by chance; None, here and below, where one has no
    covariance, as the nominal model and one by the paper's method."""
    by_chance: tuple[Apart | None, ...] = ()
    """The same at each placement."""
    curves: tuple[CurveAgreement, ...] = ()
    """Of the joints' error curves, where both have them."""


class ComparisonDocument(Document):
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
    ball_refitted: bool
    """True where the nominal model's ball was fitted to what the first calibration was."""
    plots: tuple[PlotCaption, ...] | None = None
    """Only where a page was written."""


def comparison_title(result: ComparisonDocument) -> str:
    """Return the title of the errors by placement."""
    return "; ".join(["MAE in mm", *model_remarks(result), "* trained on"])


def model_remarks(result: ComparisonDocument) -> list[str]:
    """Return what the models are, where their names do not say it."""
    remarks: list[str] = []
    if result.ball_refitted:
        first = result.models[1].name
        remarks.append(f"{NOMINAL}: its ball refitted to what {first} was trained on")
    corrected = [model.name for model in result.models if model.corrected_joints]
    if corrected:
        remarks.append(f"{joined(corrected)}: with corrected joint positions")
    return remarks


def comparison_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise.

    Of two calibrations the words say how far they are apart, and whether chance alone explains it.
    """
    rows = [pair.placements[i] for i in result.fair]
    change = pair.summary.mean if pair.summary else 0.0
    return text(
        "comparison",
        a=result.models[pair.a].name,
        b=result.models[pair.b].name,
        pair=pair,
        rows=rows,
        wins=sum(row.beyond_noise and row.mean * change > 0 for row in rows),
        chances=[chance for chance in pair.by_chance if chance is not None],
        agreement=agreement_words(pair.curves),
    )

"""Several calibrations of one robot on the same data: which is better where, beyond the noise."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property

import msgspec
import numpy as np

from ....solver.assessment import Quantiles, mm, norms, plural, quantiles
from ....solver.data import Measurement, Metrics, evaluate, kabsch, mean_metrics, targets
from ....solver.results import CurveAgreement, Document, agreement, agreement_words, fields_of
from .contenders import NOMINAL, Contender
from .types import Displacement, PlotCaption

COMPARISON = "mukca-comparison-1"
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26)
"""Half the width of a 95 % interval in standard errors, for 1 to 9 degrees of freedom."""
MANY = 2.2
"""Likewise for more."""


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
    orientation_error: float | None = None
    """[rad]; None where no orientation was measured."""
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
    """Of the ball between the two, after a rigid motion of the base frame is taken out."""
    curves: tuple[CurveAgreement, ...] = ()
    """Of the joints' error curves, where both have them."""


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
    plots: tuple[PlotCaption, ...] | None = None
    """Only where a page was written."""


@dataclass(frozen=True)
class _Compared:
    """One placement, and the predictions of every model for its samples."""

    measured: Measurement
    points: tuple[np.ndarray, ...]
    """Ball centres by each model, shape (N, 3) [m]."""
    trained: tuple[bool, ...]
    """True for each model that was fitted to this placement."""

    @cached_property
    def errors(self) -> list[np.ndarray]:
        """Distance of each ball from its true place by each model, shape (N,) [m]."""
        return [norms(points - targets(points, self.measured)) for points in self.points]

    @cached_property
    def metrics(self) -> list[Metrics]:
        """The paper's metrics of each model."""
        return [evaluate(points, self.measured) for points in self.points]


def compare(contenders: Sequence[Contender], data: Sequence[Measurement]) -> ComparisonDocument:
    """Compare calibrations, and the nominal model of the first of them, on placements."""
    names = [NOMINAL, *(contender.name for contender in contenders)]
    first = contenders[0].calibration
    compared = [
        _Compared(
            m,
            (
                first.nominal_ball(m.positions),
                *(c.calibration.models["calibrated"](m) for c in contenders),
            ),
            (False, *(c.trained_on(m) for c in contenders)),
        )
        for m in data
    ]
    curves = [None, *(contender.document.curves for contender in contenders)]
    fair = [i for i, placement in enumerate(compared) if not any(placement.trained)]
    judged = [compared[i] for i in fair]
    return ComparisonDocument(
        format=COMPARISON,
        robot_name=first.robot.name,
        models=tuple(
            ComparedModel(name=name, summary=_overall(k, judged) if judged else None)
            for k, name in enumerate(names)
        ),
        placements=tuple(map(_placement, compared)),
        fair=tuple(fair),
        pairs=tuple(
            msgspec.structs.replace(
                _pair(compared, fair, a, b), curves=agreement(curves[a], curves[b])
            )
            for b in range(1, len(names))
            for a in range(b)
        ),
    )


def _overall(k: int, judged: Sequence[_Compared]) -> ErrorsOverall:
    """Return the errors of model k over the placements that none was trained on."""
    means = mean_metrics([placement.metrics[k] for placement in judged])
    return ErrorsOverall(
        mean_absolute_error=means.mean_absolute_error,
        distance_error=means.distance_error,
        **fields_of(quantiles(np.concatenate([placement.errors[k] for placement in judged]))),
    )


def _placement(compared: _Compared) -> ComparedPlacement:
    rows = zip(compared.metrics, compared.errors, compared.trained, strict=True)
    return ComparedPlacement(
        name=compared.measured.name,
        samples=tuple(compared.measured.counts),
        models=tuple(
            ErrorsAtPlacement(**asdict(metrics), quantiles=quantiles(errors), trained_on=trained)
            for metrics, errors, trained in rows
        ),
    )


def _pair(compared: Sequence[_Compared], fair: Sequence[int], a: int, b: int) -> ComparedPair:
    """Return by how much the error of model b exceeds that of model a, sample by sample."""
    # A placement's mean difference, and the noise that its samples leave in it.
    apart = [placement.errors[b] - placement.errors[a] for placement in compared]
    rows = tuple(_beyond(d.mean(), 2 * d.std(ddof=1) / len(d) ** 0.5) for d in apart)
    # A ball in a socket does not show the base frame, so a rigid motion means nothing.
    A, B = (np.concatenate([each.points[k] for each in compared]) for k in (a, b))
    gaps = norms(kabsch(B, A).apply(B) - A)
    return ComparedPair(
        a=a,
        b=b,
        placements=rows,
        summary=_mean_difference([rows[i] for i in fair]) if fair else None,
        apart=Displacement(mean=float(gaps.mean()), max=float(gaps.max())),
    )


def _mean_difference(rows: Sequence[Difference]) -> Difference:
    """Return the mean difference over placements, and its noise."""
    means = np.array([row.mean for row in rows])
    noise = float(norms(np.array([row.noise for row in rows]))) / len(rows)
    if len(rows) > 1:
        # Errors of one placement go together, so the spread between placements counts where it
        # is larger than the samples alone would give.
        factor = STUDENT[len(rows) - 2] if len(rows) - 2 < len(STUDENT) else MANY
        noise = max(noise, factor * float(means.std(ddof=1)) / len(rows) ** 0.5)
    return _beyond(means.mean(), noise)


def _beyond(mean: float, noise: float) -> Difference:
    mean, noise = float(mean), float(noise)
    return Difference(mean=mean, noise=noise, beyond_noise=abs(mean) > noise)


def comparison_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    return f"{_errors_sentence(result, pair)} {agreement_words(pair.curves)}".strip()


def _errors_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    a, b = result.models[pair.a].name, result.models[pair.b].name
    summary = pair.summary
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(result.fair), "placement")
    where = f"over {count} that none was trained on"
    noise = f"noise \N{PLUS-MINUS SIGN}{mm(summary.noise, 3)}, 95 %"
    if not summary.beyond_noise:
        gap = mm(abs(summary.mean), 3)
        return f"{b} and {a} differ by {gap} {where}, which is within the noise ({noise})."
    better, worse = (b, a) if summary.mean < 0 else (a, b)
    rows = [pair.placements[i] for i in result.fair]
    wins = sum(row.beyond_noise and row.mean * summary.mean > 0 for row in rows)
    return (
        f"{better} is better than {worse} by {mm(abs(summary.mean), 3)} {where}, beyond the "
        f"noise ({noise}) on the whole and at {wins} of them."
    )

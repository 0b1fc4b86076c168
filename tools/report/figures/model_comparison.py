"""Several calibrations of one robot on the same data: which is better where, beyond the noise."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ....errors import MukcaError
from ....solver.assessment import (
    Quantiles,
    apart_words,
    joined,
    measurements_of,
    mm,
    plural,
    quantiles,
)
from ....solver.calibration import Calibration, differences
from ....solver.data import (
    Measurement,
    Metrics,
    evaluate,
    kabsch,
    mean_metrics,
    targets,
)
from ....solver.results import (
    Apart,
    CurveAgreement,
    Document,
    agreement,
    agreement_words,
)
from .types import Displacement, PlotCaption

COMPARISON = "mukca-comparison-1"
NOMINAL = "nominal"
SURPRISE = 0.05
CHANGED, EXPLAINED = "something changed, or is not in the model", "chance explains that"
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.2)
"""Half the width of a 95 % interval in standard errors, for 1 to 9 degrees of freedom, and more."""


class ComparisonError(MukcaError):
    """Calibrations that cannot be compared."""


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
    """How far they are apart at random poses, and by chance; None, here and below, where one has no
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


def contenders_of(files: Sequence[Path]) -> dict[str, Calibration]:
    """Return the calibrations in some files, by the shortest names that tell their folders apart.

    Those of other joints are a ComparisonError.
    """
    if len(set(files)) < len(files):
        raise ComparisonError("a calibration is named twice; name each only once")
    folders = [file.resolve().parent.parts for file in files]
    tries = [["/".join(parts[-count:]) for parts in folders] for count in (1, 2)]
    tries.append([str(file) for file in files])
    names = next(names for names in tries if len({*names, NOMINAL}) > len(files))
    contenders = dict(zip(names, map(Calibration.of_file, files), strict=True))
    first = next(iter(contenders.values()))
    joints = ", ".join(first.robot.joint_names)
    for contender in contenders.values():
        others = ", ".join(contender.robot.joint_names)
        if others != joints:
            raise ComparisonError(
                f"{contender.source}: its joints are {others}, but those of {first.source} "
                f"are {joints}; only calibrations of one robot can be compared"
            )
    return contenders


def shared_data(contenders: Iterable[Calibration]) -> list[Measurement]:
    """Return all placements that the calibrations' files hold, each once."""
    shared: dict[tuple[float, ...], Measurement] = {}
    for contender in contenders:
        for m in measurements_of(contender.document, contender.robot, contender.source):
            shared.setdefault(tuple(m.placement.positions.ravel().tolist()), m)
    return list(shared.values())


def _at_placement(
    measured: Measurement,
    points: Sequence[np.ndarray],
    lengths: Sequence[np.ndarray],
    trained_on: Sequence[bool],
) -> ComparedPlacement:
    """Return the errors of each model at a placement, by its points and the lengths of errors."""
    models = tuple(
        ErrorsAtPlacement(
            **asdict(evaluate(p, measured)),
            quantiles=quantiles(lengths[k]),
            trained_on=trained_on[k],
        )
        for k, p in enumerate(points)
    )
    return ComparedPlacement(
        name=measured.name, samples=tuple(measured.counts), models=models
    )


def compare(
    contenders: Mapping[str, Calibration], data: Sequence[Measurement]
) -> ComparisonDocument:
    """Compare calibrations, and the nominal model of the first of them, on placements.

    The ball of the nominal model is the refitted one, where that calibration keeps it.
    """
    contestants = list(contenders.values())
    first = contestants[0]
    nominal = first.ball_refitted or first.calibrated.nominal
    models = [nominal, *(contender.calibrated for contender in contestants)]
    points = [[model.predict(m) for model in models] for m in data]
    errors: list[list[np.ndarray]] = []
    placements: list[ComparedPlacement] = []
    for row, m in zip(points, data, strict=True):
        lengths = [np.linalg.norm(p - targets(p, m), axis=1) for p in row]
        errors.append(lengths)
        trained_on = [
            False,
            *(contender.was_trained_on(m) for contender in contestants),
        ]
        placements.append(_at_placement(m, row, lengths, trained_on))
    fair = [
        i
        for i, row in enumerate(placements)
        if not any(m.trained_on for m in row.models)
    ]

    def model(k: int, name: str) -> ComparedModel:
        summary = None
        if fair:
            mean = mean_metrics([placements[i].models[k] for i in fair])
            summary = ErrorsOverall.filled(
                quantiles(np.concatenate([errors[i][k] for i in fair])),
                mean_absolute_error=mean.mean_absolute_error,
                distance_error=mean.distance_error,
            )
        corrected = models[k].exported is not None
        return ComparedModel(name=name, summary=summary, corrected_joints=corrected)

    def pair(a: int, b: int) -> ComparedPair:
        rows = tuple(_beyond_noise(row[b] - row[a]) for row in errors)
        workspace: Apart | None = None
        by_chance: tuple[Apart | None, ...] = (None,) * len(data)
        if a:
            workspace, by_chance = differences(
                contestants[a - 1], contestants[b - 1], data
            )
        balls = [np.concatenate([row[k] for row in points]) for k in (a, b)]
        return ComparedPair(
            a=a,
            b=b,
            placements=rows,
            summary=_overall([rows[i] for i in fair]) if fair else None,
            workspace=workspace,
            by_chance=by_chance,
            apart=_displacement(*balls),
            curves=agreement(curves[a], curves[b]),
        )

    curves = [None, *(contender.document.curves for contender in contestants)]
    return ComparisonDocument(
        format=COMPARISON,
        robot_name=first.robot.name,
        models=tuple(model(k, name) for k, name in enumerate((NOMINAL, *contenders))),
        placements=tuple(placements),
        fair=tuple(fair),
        pairs=tuple(pair(a, b) for b in range(1, len(models)) for a in range(b)),
        ball_refitted=first.ball_refitted is not None,
    )


def _beyond_noise(changes: np.ndarray) -> Difference:
    """Return a placement's mean difference beside the noise that its samples leave in it."""
    return _beyond(changes.mean(), 2 * changes.std(ddof=1) / len(changes) ** 0.5)


def _displacement(A: np.ndarray, B: np.ndarray) -> Displacement:
    """Return how far balls are apart, shape (N, 3) [m], but for a rigid motion.

    A ball in a socket does not show the base frame, so that motion means nothing.
    """
    gaps = np.linalg.norm(kabsch(B, A).apply(B) - A, axis=1)
    return Displacement(mean=float(gaps.mean()), max=float(gaps.max()))


def _overall(rows: Sequence[Difference]) -> Difference:
    means = np.array([row.mean for row in rows])
    noise = float(np.linalg.norm([row.noise for row in rows])) / len(rows)
    if len(rows) > 1:
        # Errors of one placement go together, so the spread between placements counts where it
        # is larger than the samples alone would give.
        factor = STUDENT[min(len(rows), len(STUDENT) + 1) - 2]
        noise = max(noise, factor * float(means.std(ddof=1)) / len(rows) ** 0.5)
    return _beyond(means.mean(), noise)


def _beyond(mean: float, noise: float) -> Difference:
    mean = float(mean)
    noise = float(noise)
    return Difference(mean=mean, noise=noise, beyond_noise=abs(mean) > noise)


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
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    words = [
        _errors_sentence(result, pair),
        _chance_sentence(pair),
        agreement_words(pair.curves),
    ]
    return " ".join(filter(None, words))


def _chance_sentence(pair: ComparedPair) -> str:
    """Return how far two calibrations are apart, and whether chance alone explains it."""
    if pair.workspace is None:
        return ""
    everything = [
        pair.workspace,
        *(chance for chance in pair.by_chance if chance is not None),
    ]
    odds = len(everything) * min(chance.probability for chance in everything)
    beyond = sum(chance.beyond_chance for chance in everything[1:])
    text = f"beyond chance at {beyond} of {plural(len(everything) - 1, 'placement')}"
    reason = CHANGED if odds < SURPRISE else EXPLAINED
    return f"Apart in mm: {apart_words(pair.workspace)} in the workspace; {text}: {reason}."


def _errors_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    a = result.models[pair.a].name
    b = result.models[pair.b].name
    summary = pair.summary
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(result.fair), "placement")
    where = f"over {count} that none was trained on"
    half_width = f"\N{PLUS-MINUS SIGN}{mm(summary.noise, 3)}, 95 %"
    rows = [pair.placements[i] for i in result.fair]
    better, worse = (b, a) if summary.mean < 0 else (a, b)
    wins = sum(row.beyond_noise and row.mean * summary.mean > 0 for row in rows)
    gap = mm(abs(summary.mean), 3)
    lead = f"{better} is better than {worse} by {gap} {where}, beyond the noise"
    if summary.beyond_noise:
        return f"{lead} (noise {half_width}) on the whole and at {wins} of them."
    if wins == len(rows):
        return (
            f"{lead} at each of them; they are too few, or too unlike, to say so of other places "
            f"({half_width})."
        )
    either = f"{b} and {a} differ by {gap} {where}, which is within"
    if any(row.beyond_noise for row in rows):
        return f"{either} the spread between placements ({half_width})."
    return f"{either} the noise (noise {half_width})."

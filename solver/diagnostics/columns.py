"""Columns that do not match the model's joints: signs, ratios, orders, couplings and offsets.

Hypotheses are ranked by the nominal model; the best are fitted, and their evidence is compared with
that of all other explanations.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

from .column_hypothesis import ColumnHypothesis
from .column_ranking import last_sign, promising
from .hypotheses import (
    KINDS,
    Candidate,
    Kind,
    Scene,
    SeatSamples,
    kind_of,
    of_zero,
    sound_recordings,
)
from .robust_fit import UNEXPLAINED, RigidModel
from .stuck import STUCK

MUCH = 3.0
"""Multiple of the expected noise from which any placement may have wrong columns."""
LOWER = 0.9
"""Share of an error below which it has fallen."""
FURTHER = 0.2
"""Share of the prior probability that is left with each further sign."""
OF_COLUMNS = {
    name: kind_of(name) for name in ("sign", "ratio", "swap", "order", "coupled")
}
OF_COLUMNS["zero"] = kind_of("zero_column")
CAUSES = (
    *(kind for kind in KINDS if kind.name != "sound"),
    *OF_COLUMNS.values(),
    STUCK,
)
"""All causes that may be reported."""


def of_columns(
    model: RigidModel,
    scene: Scene,
    likeliest: Candidate,
    *,
    sound: bool,
) -> Iterator[Candidate]:
    """Yield candidates: wrong columns of all placements, of a suspect one, or of the last joint.

    ``sound``: the recordings are explained well, and only the sign of the last joint is tried.
    """
    parts = {None: scene.every}
    if not sound:
        parts |= _suspects(scene, likeliest)
    before = likeliest.parameters["noise"]
    for placement, rows in parts.items():
        samples = scene.samples.only(rows)
        samples = replace(samples, sockets=samples.sockets - samples.sockets.min())
        for hypotheses in _possible(model, scene, samples, sound=sound):
            noises: list[float] = []
            for hypothesis in hypotheses:
                readings = scene.q.copy()
                readings[rows] = hypothesis.apply(samples).q
                changed, noise = model.refitted(replace(scene, readings=readings))
                if noise < UNEXPLAINED:
                    candidate = _candidate(hypothesis, changed, placement, before)
                    noises.append(candidate.parameters["noise"])
                    yield candidate
            is_explained = min(noises, default=before) < MUCH * scene.noise
            if is_explained or placement is not None:
                break


def _suspects(
    scene: Scene,
    likeliest: Candidate,
) -> dict[str | None, slice]:
    """Return placements whose columns may be wrong: of several all noisy ones, or that accused."""
    accused = likeliest.parameters.get("placement")
    noisy = likeliest.parameters["noise"] > MUCH * scene.noise
    if len(scene.places) < 2:
        return {}
    places = zip(scene.measurements, scene.places, strict=True)
    return {m.name: rows for m, rows in places if noisy or m.name == accused}


def _possible(
    model: RigidModel,
    scene: Scene,
    samples: SeatSamples,
    *,
    sound: bool,
) -> Iterator[list[ColumnHypothesis]]:
    """Yield the hypotheses on some samples that are worth a fit, the simple ones first."""
    if not samples.is_overdetermined(len(scene.parameters)):
        return
    # near the last axis the ball hardly moves: the model's own errors may hide its sign
    last = last_sign(model, samples)
    stages = iter(()) if sound else promising(model, samples)
    yield [*next(stages, ()), *last]
    yield from stages


def _candidate(
    hypothesis: ColumnHypothesis,
    changed: Scene,
    placement: str | None,
    before: float,
) -> Candidate:
    """Return a hypothesis as a candidate, by the scene that it changed and the error ``before``.

    ``placement`` is the name of the one whose columns are wrong; None for all.
    """
    sound = sound_recordings(changed)
    if placement is None:
        hypothesis = _refined(hypothesis, sound)
    names = hypothesis.robot.joint_names
    blamed = chain.from_iterable(hypothesis.mistakes.values())
    parameters = {
        "joints": ", ".join(names[joint] for joint in blamed),
        "offsets": (0.0 - hypothesis.offsets).tolist(),
        "order": hypothesis.order.tolist(),
    }
    kind = _kind(hypothesis, before, sound.sigma)
    return sound.as_cause(kind, parameters, len(names), placement)


def _refined(
    hypothesis: ColumnHypothesis,
    sound: Candidate,
) -> ColumnHypothesis:
    """Return a hypothesis with the offsets of a fit that includes the geometry."""
    joints = hypothesis.mistakes.get("zero")
    if joints is None:
        return hypothesis
    (block,) = of_zero(sound.scene)
    together = replace(block, columns=block.columns[joints, :, 0].T[None])
    offsets = hypothesis.offsets.copy()
    offsets[joints] -= sound.evidence.posterior(together, sound.sigma)[0]
    return replace(hypothesis, offsets=offsets)


def _kind(
    hypothesis: ColumnHypothesis,
    before: float,
    after: float,
) -> Kind:
    """Return the explanation in the words of a hypothesis, with the errors [m]."""
    gain = "needs no other cause"
    if after < LOWER * before:
        gain = f"falls from {_digits(1e3 * before)} to {_digits(1e3 * after)} mm"
    form = f"{hypothesis.text} the error {gain}"
    mistakes = hypothesis.mistakes
    _, *others = mistakes
    kinds = [OF_COLUMNS[name] for name in (hypothesis.name, *others)]
    flips = len(mistakes.get("sign", ()))
    steps = (kind.advice.replace("{columns}", hypothesis.columns) for kind in kinds)
    return replace(
        kinds[0],
        prior=math.prod(kind.prior for kind in kinds) * FURTHER ** max(flips - 1, 0),
        form=form.replace("{", "{{").replace("}", "}}"),
        advice="; ".join(steps),
    )


def _digits(value: float) -> str:
    """Return a number with two digits that count, as people write it."""
    return f"{float(f'{value:.2g}'):g}"

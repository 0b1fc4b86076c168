"""Explanations of recordings, the most probable first, and what is left once one was found.

One cause at a time: the most probable one is put among what may be off, and all are compared again,
until nothing is likelier than that the rest is sound.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..data import Known, Measurement
from ..robot import choose_parameters
from .column_hypotheses import ColumnHypothesis, signs
from .columns import promising
from .distances import Scale, size_level
from .fit_error import standing_out
from .hypotheses import (
    ARMS,
    ONLY_SOUND,
    Candidate,
    Comparison,
    LinearEvidence,
    Scene,
    explained,
    of_distance,
    probabilities,
)
from .robust_fit import RigidModel, Samples, median, samples_of

ROUNDS = 8
"""Causes that are sought at most."""
MOST = 240
"""Samples of a placement that are looked at; of more, some are left out evenly."""
USUAL, USUAL_WIDTH, KNOWN_WIDTH = 2e-4, 0.6, 0.25
"""Noise of an arm of which nothing is known [m], and how far it may be off, in its logarithm;
and of one whose repeatability is known."""
SERVOS = 1e-3
"""Least noise of arms made of servos, whose gears have play [m]."""
RESOLUTION = 1e-4
"""Repeatability that a printed socket shows at best [m]."""
SURE = 0.1
"""Probability from which recordings are taken for sound."""
MUCH = 3.0
"""Noise, beside what is expected, from which any placement may have wrong columns."""
SECOND = 0.1
"""Probability from which the second explanation is told beside the first."""
LEAST = 20
"""Samples below which any model explains them."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
OF_COLUMNS = {"sign": 0.05, "swap": 0.03, "order": 0.02, "zero": 0.01}
"""Prior probabilities of mistakes in the columns."""


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


@dataclass(frozen=True)
class Finding:
    """A cause that was found, with all that its kind says of it."""

    hypothesis: Hypothesis
    code: str
    level: str


@dataclass(frozen=True)
class Explanation:
    """All that was found in recordings."""

    findings: tuple[Finding, ...]
    hypotheses: tuple[Hypothesis, ...]
    """The most probable first, where the first cause was found that matters."""
    scale: Scale | None
    scene: Scene


def scene_of(
    model: RigidModel,
    measurements: Sequence[Measurement],
    rulers: Sequence[Known[int]],
    repeatability: float | None,
    floors: Sequence[float],
) -> Scene:
    """Return recordings as a linear model about a robust fit."""
    thin = [_thinned(m) for m in measurements]
    odd = [typical is not None for typical in standing_out(floors)]
    good = [m for (m, _), bad in zip(thin, odd, strict=True) if not bad]
    fit = model.fit(samples_of(good or [m for m, _ in thin]))
    balls = [model.ball.points(model.ball.nominal + fit.x, m.positions) for m, _ in thin]
    centres = [median(b[rows]) for b, (m, _) in zip(balls, thin, strict=True) for rows in m.slices]
    return Scene(
        robot=model.robot,
        parameters=tuple(choose_parameters(model.robot)),
        measurements=tuple(m for m, _ in thin),
        rulers=tuple(rulers),
        x=fit.x,
        centres=np.array(centres) if any(odd) else fit.centres,
        floors=tuple(floors),
        noise=max(SERVOS if model.zeros else RESOLUTION, repeatability or USUAL),
        noise_width=USUAL_WIDTH if repeatability is None else KNOWN_WIDTH,
        zeros=model.zeros,
        kept=np.concatenate([numbers for _, numbers in thin]),
    )


def _thinned(measured: Measurement) -> tuple[Measurement, np.ndarray]:
    """Return a placement with some of its samples, and the number of each in its socket."""
    most = max(MOST // len(measured.counts), 2)
    rows = [np.linspace(0, n - 1, min(n, most)).astype(int) for n in measured.counts]
    if max(measured.counts) <= most:
        return measured, np.concatenate(rows)
    placement = measured.placement
    indices = [
        np.flatnonzero(placement.sockets == k)[r]
        for k, r in zip(measured.sockets, rows, strict=True)
    ]
    kept: list[int] = np.sort(np.concatenate(indices)).tolist()
    samples = tuple(placement.samples[i] for i in kept)
    return replace(measured, placement=replace(placement, samples=samples)), np.concatenate(rows)


@dataclass(frozen=True)
class _Option:
    """One explanation among all, and what follows where it is right."""

    name: str
    log: float
    """Logarithm of prior probability and likelihood."""
    finding: Callable[[float], Finding]
    """From its probability."""
    after: Callable[[], Scene]


def explain(model: RigidModel, scene: Scene) -> Explanation:
    """Return what explains recordings, cause after cause; nothing for very few samples."""
    if len(scene.q) < LEAST:
        return Explanation((), (), _scale(scene), scene)
    findings: list[Finding] = []
    listed: tuple[Hypothesis, ...] = ()
    sized, decided, told = scene, False, False
    options: list[_Option] = []
    shares: dict[str, float] = {}
    for _ in range(ROUNDS):
        comparison = Comparison(scene)
        options = [_of_candidate(comparison, c) for c in comparison.candidates]
        shares = _shares(options)
        if scene.readings is None and not told:
            sound = shares["sound"] >= SURE
            options += _of_columns(model, scene, max(options, key=lambda o: o.log), sound=sound)
            shares = _shares(options)
        likely = max(shares, key=lambda name: shares[name])
        listed = listed or _listed(options, shares)
        if likely == "sound" or shares["sound"] >= SURE:
            break
        own = sorted((o for o in options if o.name == likely), key=lambda o: -o.log)
        sound_log = max(o.log for o in options if o.name == "sound")
        own = [o for o in own if likely == "ball_sample" and o.log > sound_log] or own[:1]
        found = [o.finding(shares[likely]) for o in own]
        of_all = "placement" not in found[0].hypothesis.parameters
        if of_all and told:
            break  # what is left of one cause of all looks like another
        findings, told = [*findings, *found], told or of_all
        if not decided and found[0].level == "error":
            listed, decided = _listed(options, shares), True
        before, scene = scene, own[0].after()
        more = [f for o in own[1:] for f in o.after().found[len(before.found) :]]
        scene = replace(scene, found=(*scene.found, *more))
        sized = sized if likely in ("distance", "scaled") else scene
    size = _scale(sized)
    if size is not None and not told and _is_doubtful(size):
        doubt = next(o for o in options if o.name == "distance")
        findings.append(doubt.finding(shares["distance"]))
    findings = [_with_deviation(f, size) for f in findings]
    return Explanation(tuple(findings), listed, size, scene)


def _with_deviation(finding: Finding, size: Scale | None) -> Finding:
    """Return a finding with how well the arm's size is known, if it is one on that."""
    told = finding.hypothesis
    if told.name != "distance":
        return finding
    parameters = {**told.parameters, "deviation": None if size is None else size.deviation}
    return replace(finding, hypothesis=replace(told, parameters=parameters))


def _is_doubtful(size: Scale) -> bool:
    """Return True for a size that is off by more than arms are, though not surely."""
    off = abs(float(np.log1p(max(size.value, -0.9))))
    return size_level(size.value, size.deviation) is not None and off > 3 * size.deviation


def _of_candidate(comparison: Comparison, candidate: Candidate) -> _Option:
    kind, scene = candidate.kind, comparison.scene

    def finding(probability: float) -> Finding:
        parameters, text = comparison.found(candidate)
        advice = kind.advice.format(**parameters)
        hypothesis = Hypothesis(kind.name, probability, dict(parameters), text, advice, kind.tell)
        return Finding(hypothesis, kind.code or kind.name, kind.level)

    def after() -> Scene:
        if kind.noise is not None:
            return replace(scene, noise=max(scene.noise, candidate.sigma))
        return explained(scene, candidate)

    return _Option(kind.name, candidate.log_evidence, finding, after)


def _of_columns(
    model: RigidModel, scene: Scene, likeliest: _Option, *, sound: bool
) -> list[_Option]:
    """Return wrong columns of all placements, or of the one that is accused.

    Where all seems sound, only the last joint's sign is tried, which the ball near its axis hides.
    """
    told = dict[str, Any](likeliest.finding(1.0).hypothesis.parameters)
    tried: list[tuple[slice, str | None]] = [(slice(0, len(scene.q)), None)]
    for rows, measured in zip(scene.places, scene.measurements, strict=True):
        accused = told.get("placement") == measured.name or told["noise"] > MUCH * scene.noise
        if accused and not sound and len(scene.places) > 1:
            tried.append((rows, measured.name))
    found: list[_Option] = []
    for rows, placement in tried:
        some = Samples(scene.q[rows], scene.sockets[rows] - scene.sockets[rows].min())
        if not some.is_overdetermined(len(scene.x)):
            continue
        last = [*signs(model.robot, 1)][-1:]
        for wrong in last if sound else promising(model, some):
            q = scene.q.copy()
            q[rows] = wrong.apply(some).positions
            fit = model.fit(Samples(q, scene.sockets))
            changed = replace(scene, x=fit.x, centres=fit.centres, readings=q)
            best = Comparison(changed, ONLY_SOUND).candidates[0]
            prior = float(np.log(OF_COLUMNS[wrong.name] / len(scene.robot.actuated)))
            parameters = _parameters(wrong, placement, best.sigma)
            log = best.log_evidence + prior
            found.append(_column(wrong, log, parameters, likeliest, changed))
    return found


def _parameters(wrong: ColumnHypothesis, placement: str | None, sigma: float) -> dict[str, Any]:
    names = wrong.robot.joint_names
    return {
        "joints": ", ".join(names[j] for joints in wrong.mistakes.values() for j in joints),
        "offsets": wrong.offsets.tolist(),
        "order": wrong.order.tolist(),
        "noise": sigma,
        **({} if placement is None else {"placement": placement}),
    }


def _column(
    wrong: ColumnHypothesis,
    log: float,
    parameters: dict[str, Any],
    likeliest: _Option,
    changed: Scene,
) -> _Option:
    def finding(probability: float) -> Finding:
        before = dict[str, Any](likeliest.finding(1.0).hypothesis.parameters)["noise"]
        after = parameters["noise"]
        gain = f"falls from {1e3 * before:.2g} to {1e3 * after:.2g} mm"
        text = f"{wrong.text} the error {gain if after < 0.9 * before else 'needs no other cause'}"
        tell = "read one pose at the arm, and compare it with its row"
        hypothesis = Hypothesis(wrong.name, probability, parameters, text, wrong.advice, tell)
        code = "swap" if wrong.name == "order" else wrong.name
        return Finding(hypothesis, code, "error")

    return _Option(wrong.name, log, finding, lambda: changed)


def _shares(options: Sequence[_Option]) -> dict[str, float]:
    """Return the probability of each name."""
    shares: dict[str, float] = {}
    for option, share in zip(options, probabilities([o.log for o in options]), strict=True):
        shares[option.name] = shares.get(option.name, 0.0) + float(share)
    return shares


def _listed(options: Sequence[_Option], shares: Mapping[str, float]) -> tuple[Hypothesis, ...]:
    """Return the best explanation of each name, the most probable first."""
    best: dict[str, _Option] = {}
    for option in options:
        if option.name not in best or option.log > best[option.name].log:
            best[option.name] = option
    kept = sorted((n for n in best if shares[n] >= LISTED), key=lambda n: -shares[n])
    return tuple(best[name].finding(shares[name]).hypothesis for name in kept)


def _scale(scene: Scene) -> Scale | None:
    """Return the arm's size by the known distances; None where none is known."""
    blocks = list(of_distance(scene))
    if not blocks:
        return None
    sigma = next(c for c in Comparison(scene, ONLY_SOUND).candidates).sigma
    evidence = LinearEvidence(scene.residuals, scene.nuisances)
    mean, covariance = evidence.posterior(blocks[0], sigma)
    return Scale(float(mean[0]), max(float(covariance[0, 0]) - ARMS**2, 1e-10) ** 0.5)


def cause(hypotheses: Sequence[Hypothesis]) -> str:
    """Return the first cause in words, and the second where it may be that; empty for none."""
    if not hypotheses or hypotheses[0].name == "sound":
        return ""
    first, *others = hypotheses
    words = f"most probable cause ({_percent(first.probability)}): {first.text}; {first.advice}"
    second = next((h for h in others if h.probability > SECOND and h.name != "sound"), None)
    if second is None:
        return words
    tell = first.tell or second.tell
    return (
        f"{words}. It cannot be told from this ({_percent(second.probability)}): {second.text}; to "
        f"tell them, {tell}"
    )


def _percent(share: float) -> str:
    return f"{100 * min(share, 0.999):.3g} %"

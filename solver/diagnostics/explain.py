"""Explanations of recordings, the most probable first, and what is left once one was found.

One cause at a time: the most probable one is put among what may be off, and all are compared again,
until nothing is likelier than that the rest is sound.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Known, Measurement
from ..results import Hypothesis
from ..robot import Robot, choose_parameters
from .columns import of_columns
from .configurations import Scale, size_level
from .hypotheses import ARMS, OF_SIZE, Candidate, Comparison, Scene, explained
from .hypothesis import Finding, Option, listed_of, shares_of
from .robust_fit import ABOUT, FEW, UNEXPLAINED, RigidModel, median, samples_of

ROUNDS = 8
"""Causes that are sought at most."""
MOST = 240
"""Samples of a placement that are looked at; of more, some are left out evenly."""
USUAL, USUAL_WIDTH, KNOWN_WIDTH = 2e-4, 0.6, 0.25
"""Noise of an arm of which nothing is known [m], and how far it may be off, in its logarithm;
and of one whose repeatability is known."""
SERVOS = 4e-4
"""Noise of arms made of servos beside the play of their gears [m]."""
RESOLUTION = 1e-4
"""Repeatability that a printed socket shows at best [m]."""
SURE = 0.1
"""Probability from which recordings are taken for sound."""
ALL = {"samples", "distances"}
BAD_RATIO = 2.5
"""A placement is not to be trusted if the fit to it alone leaves this many times the error that is
usual for the others."""
EXACT = 1e-5
"""Largest error that a fit leaves of fewer samples than it has unknowns [m]: it says nothing."""
OPEN = ("distance", "scaled", "version")
"""Explanations that leave the arm's size open."""
LEAST, MORE = 8, 20
"""Samples below which any model explains them, and below which only errors are told."""


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
    start: np.ndarray | None = None,
) -> Scene:
    """Return recordings as a linear model about a robust fit, begun at some unknowns."""
    thin = [_thinned(m) for m in measurements]
    odd = [typical is not None for typical in standing_out(floors)]
    good = [m for (m, _), bad in zip(thin, odd, strict=True) if not bad]
    some = samples_of(good or [m for m, _ in thin]).thinned(ABOUT, FEW)
    fit = model.fit(some, start=start)
    balls = [model.points(fit.x, m.positions) for m, _ in thin]
    centres = [median(b[rows]) for b, (m, _) in zip(balls, thin, strict=True) for rows in m.slices]
    return Scene(
        robot=model.robot,
        parameters=tuple(choose_parameters(model.robot)),
        measurements=tuple(m for m, _ in thin),
        rulers=tuple(rulers),
        x=fit.x,
        by_scale=model.by_scale,
        centres=np.array(centres) if any(odd) else fit.centres,
        floors=tuple(floors),
        noise=SERVOS if model.zeros else max(RESOLUTION, repeatability or USUAL),
        noise_width=USUAL_WIDTH if model.zeros or repeatability is None else KNOWN_WIDTH,
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


def explain(model: RigidModel, scene: Scene) -> Explanation:
    """Return what explains recordings, cause after cause; nothing for very few samples."""
    if len(scene.q) < LEAST:
        return Explanation((), (), _scale(scene)[0], scene)
    findings: list[Finding] = []
    listed: tuple[Hypothesis, ...] = ()
    decided, told, sized = False, set[str](), scene
    of_size: set[int] = set()
    options: list[Option] = []
    shares: dict[str, float] = {}
    for _ in range(ROUNDS):
        comparison = Comparison(scene)
        options = [_of_candidate(comparison, c) for c in comparison.candidates]
        shares = shares_of(options)
        if scene.readings is None and "samples" not in told:
            sound = shares["sound"] >= SURE
            options += of_columns(model, scene, max(options, key=lambda o: o.log), sound=sound)
            shares = shares_of(options)
        likely = max(shares, key=lambda name: shares[name])
        listed = listed or listed_of(options, shares)
        if likely == "sound" or shares["sound"] >= SURE:
            break
        own = sorted((o for o in options if o.name == likely), key=lambda o: -o.log)
        sound_log = max(o.log for o in options if o.name == "sound")
        own = [o for o in own if likely == "ball_sample" and o.log > sound_log] or own[:1]
        found = [o.finding(shares[likely]) for o in own]
        if len(scene.q) < MORE and found[0].level != "error":
            listed = listed if findings else ()
            break
        if "placement" not in found[0].hypothesis.parameters:
            if told & own[0].residuals:
                break  # what is left of one cause of all looks like another
            told |= own[0].residuals
        findings = [*findings, *found]
        if not decided and found[0].level == "error":
            listed, decided = listed_of(options, shares), True
        before, scene = scene, own[0].after()
        more = [f for o in own[1:] for f in o.after().found[len(before.found) :]]
        scene = replace(scene, found=(*scene.found, *more))
        if likely in OPEN:
            of_size.add(id(scene.found[-1]))
        else:
            kept = tuple(one for one in scene.found if id(one) not in of_size)
            sized = replace(scene, found=kept)
    size, doubt = _scale(sized)
    if size is None or doubt is None:
        return Explanation(tuple(findings), listed, size, scene)
    off = abs(float(np.log1p(max(size.value, -0.9))))  # by more than arms are, though not surely
    doubtful = size_level(size.value, size.deviation) is not None and off > 3 * size.deviation
    if not told and doubtful:
        findings.append(doubt.finding(shares["distance"]))
    return Explanation(tuple(_again(f, doubt, size) for f in findings), listed, size, scene)


def _again(finding: Finding, doubt: Option, size: Scale) -> Finding:
    """Return a finding; one on the arm's size as it is with all else that was found."""
    if finding.hypothesis.name != "distance":
        return finding
    finding = doubt.finding(finding.hypothesis.probability)
    parameters = {**finding.hypothesis.parameters, "deviation": size.deviation}
    return replace(finding, hypothesis=replace(finding.hypothesis, parameters=parameters))


def _of_candidate(comparison: Comparison, candidate: Candidate) -> Option:
    kind, scene = candidate.kind, comparison.scene

    def finding(probability: float) -> Finding:
        parameters, text = comparison.found(candidate)
        advice = kind.advice.format(**parameters)
        hypothesis = Hypothesis(kind.name, probability, dict(parameters), text, advice, kind.tell)
        return Finding(hypothesis, kind.code or kind.name, kind.level)

    def after() -> Scene:
        if kind.noise is not None:
            return replace(scene, noise=max(scene.noise, candidate.sigma))
        if kind.changed is not None:
            return kind.changed(scene, candidate.parameters)
        return explained(scene, candidate)

    samples = candidate.block.rows.start < scene.all_samples.stop
    residuals = {"samples" if samples else "distances"} if kind.noise is None else ALL
    return Option(kind.name, candidate.log_evidence, residuals, finding, after)


def _scale(scene: Scene) -> tuple[Scale | None, Option | None]:
    """Return the arm's size by the known distances, and the wrong distance that it may be."""
    comparison = Comparison(scene, OF_SIZE)
    wrong = comparison.candidates
    if not wrong:
        return None, None
    mean, covariance = comparison.evidence.posterior(wrong[0].block, wrong[0].sigma)
    deviation = max(float(covariance[0, 0]) - ARMS**2, 1e-10) ** 0.5
    return Scale(float(mean[0]), deviation), _of_candidate(comparison, wrong[0])


def fitted_alone(robot: Robot, measurements: Sequence[Measurement]) -> dict[str, float]:
    """Return the error that each placement leaves when fitted alone, by its name [m].

    It is the mean distance of its samples from their socket, each by its weight, by a robust
    rigid fit to nothing but them.
    """
    model = RigidModel(robot, choose_parameters(robot))
    return {m.name: model.fit(samples_of([m])).error for m in measurements}


def standing_out(floors: Sequence[float]) -> list[float | None]:
    """Return, for each placement that stands out, the error that it should leave by the others [m].

    It is None for each that leaves about as much as the others. ``floors`` are the errors that each
    leaves when fitted alone [m].
    """
    typical = [_typical([*floors[:i], *floors[i + 1 :]]) for i in range(len(floors))]
    return [
        t if f > BAD_RATIO * max(t, EXACT) else None for f, t in zip(floors, typical, strict=True)
    ]


def _typical(others: Sequence[float]) -> float:
    """Return the error that a placement should leave by the others' [m]; infinity if unknown."""
    typical = float(np.median(others)) if others else np.inf
    if len(others) == 1:
        typical = max(typical, UNEXPLAINED / BAD_RATIO)
    return typical if typical < UNEXPLAINED else np.inf

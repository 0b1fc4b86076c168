"""Explanations of recordings, one after the other.

The most probable one is added to the nuisances, and all others are compared again, until that of
sound recordings is the most probable.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bayes.model import probabilities_by_name
from ..data import (
    CALIPER_DEVIATION,
    STANDARD_LOAD,
    Known,
    KnownDistance,
    Load,
    Measurement,
    RobotRecordings,
    places_of,
)
from ..results import Hypothesis
from ..robot import Robot
from .columns import of_columns
from .hypotheses import (
    KINDS,
    Candidate,
    Comparison,
    Kind,
    Scene,
    evenly,
    likeliest_of,
    medians,
    samples_of,
)
from .robust_fit import ABOUT, FEW, UNEXPLAINED, RigidModel
from .stuck import of_stuck

ROUNDS = 8
"""Largest number of causes."""
MOST = 240
"""Samples of a placement that are used at most, evenly chosen."""
USUAL, USUAL_WIDTH, KNOWN_WIDTH = 2e-4, 0.6, 0.25
"""Prior noise of an arm of unknown repeatability [m], the standard deviation of its logarithm, and
that where the repeatability is known."""
INSTRUMENTS = 1.0
"""That of the noise of points: trackers measure to 0.02 mm, cameras to a millimetre."""
SERVOS = 4e-4
"""Noise of arms made of servos apart from the play of their gears [m]."""
RESOLUTION = 1e-4
"""Repeatability that a printed socket shows at best [m]."""
SURE = 0.1
"""Probability of sound recordings from which they are accepted as sound."""
BAD_RATIO = 2.5
"""Factor on the usual error of the other placements, beyond which one stands out."""
EXACT = 1e-5
"""Largest error of a fit to fewer samples than unknowns [m], which means nothing."""
SECOND = 0.1
"""Probability from which the second explanation is reported with the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
ALIKE, FEW_UNKNOWNS = 10.0, 3
"""Explanations of so many unknowns at most whose chi-square differs by less fit as well: those with
more are less probable by their number alone, and both are named."""
OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
MENDER = "solve"
"""The verb that sets recordings right unless told otherwise, as the texts of causes have it."""
LEAST, MORE = 8, 20
"""Fewest samples for any explanation, and for explanations that are only warnings."""


@dataclass(frozen=True)
class Given:
    """Settings of an inspection: known distances and the load."""

    known: Sequence[KnownDistance] = ()
    """Distances measured beside those between each placement's sockets."""
    deviation: float = CALIPER_DEVIATION
    """Standard deviation of the latter [m]."""
    load: Load = STANDARD_LOAD
    """Gravity and payload."""
    mender: str = MENDER
    """The verb that sets recordings right, in the words of advice."""
    trained: Sequence[str] = ()
    """Names of the placements to train on; none where all may be. What is wrong in others does
    nothing to the model."""


def scene_of(
    model: RigidModel,
    measurements: Sequence[Measurement],
    lengths: Sequence[Known[int]],
    repeatability: float | None,
    floors: Sequence[float],
    start: np.ndarray | None = None,
) -> Scene:
    """Return recordings as a linear model about a robust fit, begun at some unknowns."""
    width = USUAL_WIDTH if model.zeros or repeatability is None else KNOWN_WIDTH
    width = INSTRUMENTS if any(m.kind == "points" for m in measurements) else width
    thin, numbers = zip(*map(_thinned, measurements), strict=True)
    outliers = standing_out(floors)
    sound = [m for m, typical in zip(thin, outliers, strict=True) if typical is None]
    fit = model.fit(samples_of(sound or thin).thinned(ABOUT, FEW), start=start)
    centres, turns = fit.centres, fit.R
    if len(sound) < len(thin):
        samples = samples_of(thin)
        balls = model.points(fit.x, samples.positions)
        turns = samples.robustly_aligned(balls)
        centres = medians(balls - samples.offsets(turns), samples)
    return Scene(
        robot=model.robot,
        parameters=model.parameters,
        measurements=thin,
        known=tuple(lengths),
        x=fit.x,
        by_scale=model.by_scale,
        centres=centres,
        R=turns,
        floors=tuple(floors),
        noise=SERVOS if model.zeros else max(RESOLUTION, repeatability or USUAL),
        noise_width=width,
        zeros=model.zeros,
        numbers=np.concatenate(numbers),
    )


def scene_loaded(
    model: RigidModel,
    measurements: Sequence[Measurement],
    given: Given,
    repeatability: float | None,
) -> Scene:
    """Return recordings of which something is known as a linear model; see :func:`scene_of`.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    recordings = RobotRecordings(model.robot, measurements)
    places = places_of(
        [recordings],
        lengths=given.known,
        deviation=given.deviation,
        require_scale=False,
    )
    floors = list(fitted_alone(model.robot, measurements).values())
    scene = scene_of(model, measurements, places.known, repeatability, floors)
    return replace(scene, load=given.load)


def _thinned(measured: Measurement) -> tuple[Measurement, np.ndarray]:
    """Return a placement with some of its samples, and the number of each in its socket."""
    limit = max(MOST // len(measured.counts), 2)
    numbers = [evenly(count, limit) for count in measured.counts]
    ranks: list[np.ndarray] = []
    for rows, chosen in zip(measured.slices, numbers, strict=True):
        ranks.append(measured.order[rows][chosen])
    thin = measured.only(np.sort(np.concatenate(ranks)))
    return thin, np.concatenate(numbers)


def explain(
    model: RigidModel, scene: Scene
) -> tuple[list[Candidate], tuple[Hypothesis, ...]]:
    """Return causes, and all explanations at the round of the first error."""
    causes, listed = list[Candidate](), tuple[Hypothesis, ...]()
    if len(scene.q) < LEAST:
        return causes, listed
    decided, kinds, residuals = False, KINDS, set[str]()
    for _ in range(ROUNDS):
        candidates = _candidates(model, scene, kinds, residuals)
        shares = shares_of(candidates)
        listed = listed or listed_of(candidates, shares)
        accepted = _accepted(candidates, shares)
        if not accepted:
            break
        first, *alternatives = accepted
        if len(scene.q) < MORE and first.kind.level != "error":
            listed = listed if causes else ()
            break
        if first.of_all:
            if residuals & first.residuals:
                break  # residuals of one global cause would look like another
            residuals |= first.residuals
        causes += accepted
        if not decided and first.kind.level == "error":
            listed, decided = listed_of(candidates, shares), True
        if first.has_no_effect:
            kinds = tuple(kind for kind in kinds if kind is not first.kind)
        scene = _beside(_scene_after(model, first), alternatives)
    return causes, listed


def _candidates(
    model: RigidModel, scene: Scene, kinds: Sequence[Kind], residuals: Collection[str]
) -> list[Candidate]:
    """Return all explanations of a scene, sound recordings first.

    The meaning of columns is asked where no cause of all samples was accepted before.
    """
    candidates = Comparison(scene, kinds).candidates
    if scene.readings is not None or "samples" in residuals:
        return candidates
    sound = shares_of(candidates)["sound"] >= SURE
    candidates += of_columns(model, scene, likeliest_of(candidates), sound=sound)
    if not sound:
        candidates += of_stuck(model, scene)
    return candidates


def _accepted(
    candidates: Sequence[Candidate], shares: Mapping[str, float]
) -> list[Candidate]:
    """Return what is right of the most probable kind, the best first; none where all is sound."""
    likeliest = max(shares, key=lambda name: shares[name])
    if likeliest == "sound" or shares["sound"] >= SURE:
        return []
    of_kind = [
        candidate for candidate in candidates if candidate.kind.name == likeliest
    ]
    of_kind.sort(key=lambda candidate: -candidate.log_evidence)
    sound = candidates[0]
    separate = [
        c for c in of_kind if c.kind.separate and c.log_evidence > sound.log_evidence
    ]
    return separate or of_kind[:1]


def _beside(scene: Scene, alternatives: Sequence[Candidate]) -> Scene:
    """Return a scene in which more candidates of the same round are right, too."""
    explained = list(scene.explained)
    for candidate in alternatives:
        explained += candidate.after().explained[len(candidate.scene.explained) :]
    return replace(scene, explained=tuple(explained))


def _scene_after(model: RigidModel, accepted: Candidate) -> Scene:
    """Return the scene where an explanation is right, fitted anew where it turns joints."""
    kind = accepted.kind
    right = accepted if kind.turns is None else _turned_back(model, accepted)
    scene = right.after()
    if accepted.of_all and kind.noise is None:
        return replace(scene, floors=())  # of fits without it
    return scene


def _turned_back(model: RigidModel, accepted: Candidate) -> Candidate:
    """Return an explanation after a fit of joints that are turned back by it.

    There its unknown stays among the nuisances: its size is known only so well.
    """
    scene, turns = accepted.scene, accepted.kind.turns
    assert turns is not None
    joint = scene.robot.joint_names.index(accepted.parameters["joint"])
    measurements: list[Measurement] = []
    for m in scene.measurements:
        offsets = np.zeros_like(m.positions)
        readings = m.placement.positions[:, joint]
        offsets[:, joint] = -accepted.parameters["offset"] * turns(readings)
        measurements.append(m.shifted(offsets))
    fitted, _ = model.refitted(
        replace(scene, measurements=tuple(measurements)), scene.x
    )
    (block,) = accepted.kind.blocks(fitted)
    return replace(accepted, scene=fitted, block=block.only([joint]))


def fitted_alone(robot: Robot, measurements: Sequence[Measurement]) -> dict[str, float]:
    """Return the error that a robust rigid fit to each placement alone leaves, by its name [m].

    It is the mean distance of its samples from their socket, each by its weight.
    """
    model = RigidModel(robot)
    return {m.name: model.fit(samples_of([m])).error for m in measurements}


def standing_out(floors: Sequence[float]) -> list[float | None]:
    """Return the error that a placement should leave by the others', if it stands out, else None.

    ``floors`` are the errors that each placement leaves when fitted alone [m].
    """
    outliers: list[float | None] = []
    for i, floor in enumerate(floors):
        others = [*floors[:i], *floors[i + 1 :]]
        typical = float(np.median(others)) if others else np.inf
        if len(others) == 1:
            typical = max(typical, UNEXPLAINED / BAD_RATIO)
        stands_out = typical < UNEXPLAINED and floor > BAD_RATIO * max(typical, EXACT)
        outliers.append(typical if stands_out else None)
    return outliers


def shares_of(candidates: Sequence[Candidate]) -> dict[str, float]:
    """Return the probability of each name, by the logarithms of the evidence."""
    logs = np.array([candidate.log_evidence for candidate in candidates])
    return probabilities_by_name(
        [candidate.kind.name for candidate in candidates], logs
    )


def listed_of(
    candidates: Sequence[Candidate], shares: Mapping[str, float]
) -> tuple[Hypothesis, ...]:
    """Return the best explanation of each name, the most probable first."""
    # Of candidates that are equal but for rounding the first counts.
    best: dict[str, Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: -round(c.log_evidence, 6)):
        best.setdefault(candidate.kind.name, candidate)
    likely = sorted((n for n in best if shares[n] >= LISTED), key=lambda n: -shares[n])
    first = best[likely[0]]
    rivals = {n for n, candidate in best.items() if _fits_as_well(candidate, first)}
    others = [n for n in best if n in rivals and n not in likely]
    hypotheses: list[Hypothesis] = []
    for name in likely + others:
        hypothesis = best[name].hypothesis(shares[name])
        hypotheses.append(replace(hypothesis, fits_as_well=name in rivals))
    return tuple(hypotheses)


def _fits_as_well(candidate: Candidate, first: Candidate) -> bool:
    """Tell whether a candidate of few unknowns leaves much the same chi-square as the first."""
    blocks, evidence, sigma = (
        (candidate.block, first.block),
        first.evidence,
        first.sigma,
    )
    same = candidate is not first and candidate.evidence is evidence
    if not same or not all(0 < block.unknowns <= FEW_UNKNOWNS for block in blocks):
        return False
    gain, best = [evidence.chi_square(block, sigma) for block in blocks]
    return abs(gain - best) < ALIKE < 0.5 * best


def cause(hypotheses: Sequence[Hypothesis]) -> str:
    """Return the first cause in words, and the second where it may be that; empty for none."""
    if not hypotheses or hypotheses[0].name == "sound":
        return ""
    first, *alternatives = hypotheses
    words = f"most probable cause ({_percent(first.probability)}): {first.text}; {first.advice}"
    words += f" (docs: causes/{first.name})"
    rivals = (h for h in alternatives if h.probability > SECOND or h.fits_as_well)
    second = next((h for h in rivals if h.name != "sound"), None)
    if second is None:
        return words
    how = "it fits as well" if second.fits_as_well else _percent(second.probability)
    words += f". It cannot be told from this ({how}): {second.text}"
    return f"{words}; to tell them, {first.tell or second.tell}"


def _percent(share: float) -> str:
    return f"{100 * min(share, 0.999):.3g} %"

"""Explanations of recordings, one after the other.

The most probable one is added to the nuisances, and all others are compared again, until that of
sound recordings is the most probable.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import Measurement
from ..results import Hypothesis
from .columns import of_columns
from .hypotheses import KINDS, Candidate, Comparison, Kind, Scene, likeliest_of
from .listing import listed_of, shares_of
from .robust_fit import RigidModel
from .stuck import of_stuck

ROUNDS = 8
"""Largest number of causes."""
SURE = 0.1
"""Probability of sound recordings from which they are accepted as sound."""
OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
LEAST = 8
"""Fewest samples for any explanation."""
MORE = 20
"""Fewest samples for explanations that are only warnings."""


def explain(
    model: RigidModel,
    scene: Scene,
) -> tuple[list[Candidate], tuple[Hypothesis, ...]]:
    """Return causes, and all explanations at the round of the first error."""
    causes: list[Candidate] = []
    listed: tuple[Hypothesis, ...] = ()
    count = len(scene.q)
    if count < LEAST:
        return causes, listed
    kinds = KINDS
    residuals = set[str]()
    is_decided = False
    for _ in range(ROUNDS):
        candidates = _candidates(model, scene, kinds, residuals)
        shares = shares_of(candidates)
        listed = listed or listed_of(candidates, shares)
        accepted = _accepted(candidates, shares)
        if not accepted:
            break
        first, *alternatives = accepted
        is_error = first.kind.level == "error"
        if count < MORE and not is_error:
            listed = listed if causes else ()
            break
        if first.of_all:
            if residuals & first.residuals:
                break  # residuals of one global cause would look like another
            residuals |= first.residuals
        causes += accepted
        if is_error and not is_decided:
            listed = listed_of(candidates, shares)
            is_decided = True
        if first.has_no_effect:
            kinds = tuple(kind for kind in kinds if kind is not first.kind)
        scene = _beside(_scene_after(model, first), alternatives)
    return causes, listed


def _candidates(
    model: RigidModel,
    scene: Scene,
    kinds: Sequence[Kind],
    residuals: Collection[str],
) -> list[Candidate]:
    """Return all explanations of a scene, sound recordings first.

    The meaning of columns is asked where no cause of all samples was accepted before.
    """
    candidates = Comparison(scene, kinds).candidates
    if scene.readings is not None or "samples" in residuals:
        return candidates
    sound = shares_of(candidates)["sound"] >= SURE
    likeliest = likeliest_of(candidates)
    candidates += of_columns(model, scene, likeliest, sound=sound)
    if not sound:
        candidates += of_stuck(model, scene)
    return candidates


def _accepted(
    candidates: Sequence[Candidate],
    shares: Mapping[str, float],
) -> list[Candidate]:
    """Return what is right of the most probable kind, the best first; none where all is sound."""
    likeliest = max(shares, key=lambda name: shares[name])
    if likeliest == "sound" or shares["sound"] >= SURE:
        return []
    of_kind = [c for c in candidates if c.kind.name == likeliest]
    of_kind.sort(key=lambda candidate: -candidate.log_evidence)
    evidence_of_sound = candidates[0].log_evidence
    separate = [
        candidate
        for candidate in of_kind
        if candidate.kind.separate and candidate.log_evidence > evidence_of_sound
    ]
    return separate or of_kind[:1]


def _beside(scene: Scene, alternatives: Sequence[Candidate]) -> Scene:
    """Return a scene in which more candidates of the same round are right, too."""
    explained = list(scene.explained)
    for candidate in alternatives:
        before = len(candidate.scene.explained)
        explained += candidate.after().explained[before:]
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
    correction, _ = accepted.evidence.posterior(accepted.block, accepted.sigma)
    measurements: list[Measurement] = []
    for m in scene.measurements:
        offsets = np.zeros_like(m.positions)
        readings = m.placement.positions[:, joint]
        offsets[:, joint] = correction * turns(readings)
        measurements.append(m.shifted(offsets))
    turned = replace(scene, measurements=tuple(measurements))
    fitted, _ = model.refitted(turned, scene.x)
    (block,) = accepted.kind.blocks(fitted)
    return replace(accepted, scene=fitted, block=block.only([joint]))

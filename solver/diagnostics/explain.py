"""Causes of recordings, one after the other.

The most probable cause is accepted and becomes a nuisance, and all others are compared again, until
sound recordings are probable enough.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..results import Hypothesis
from .columns import of_columns
from .hypotheses import KINDS, Candidate, Comparison, Scene, likeliest_of
from .ranking import Ranking, outliers, ranking_of
from .robust_fit import RigidModel
from .stuck import of_stuck

OF_JOINTS = ("sign", "ratio", "swap", "coupled", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
LEAST = 8
"""Fewest samples for any explanation."""
MORE = 20
"""Fewest samples for explanations that are only warnings."""


@dataclass(frozen=True)
class Acceptance:
    """Thresholds of causes: log Bayes factors against sound recordings, and a number of rounds."""

    first: float
    """That of all causes together from which the first is accepted."""
    further: float
    """The same of a further one."""
    rounds: int
    """Largest number of causes, those at once counted as one."""
    separate: float | None = None
    """That from which several causes of the most probable kind are accepted at once, where each may
    hold; None to accept the most probable cause, whatever others of its kind are."""

    def accepted(
        self,
        ranking: Ranking,
        before: Sequence[Candidate],
    ) -> list[Candidate]:
        """Return the causes of a ranking that are right, the best first; none if all is sound."""
        if ranking.total_factor <= (self.further if before else self.first):
            return []
        if self.separate is None:
            return [ranking.best]
        likeliest = max(ranking.shares, key=ranking.shares.__getitem__)
        of_kind = [c for c in ranking.candidates if c.kind.name == likeliest]
        of_kind.sort(key=lambda candidate: -candidate.log_evidence)
        first, *others = of_kind
        # residuals of one global cause would look like another
        alike = (c for c in before if c.of_all and c.residuals & first.residuals)
        if first is ranking.sound or (first.of_all and any(alike)):
            return []
        if not first.kind.separate:
            return [first]
        return [first, *(c for c in others if ranking.factor(c) > self.separate)]


SURE = math.log(9)
"""Log Bayes factor of all causes up to which recordings count as sound, with a probability of a
tenth there."""
SAVED = Acceptance(SURE, SURE, rounds=8, separate=0.0)
"""Thresholds of causes of saved recordings."""


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
    levels = set[str]()
    for ranking, accepted in rounds(scene, partial(_ranking, model), SAVED):
        levels_of_round = {cause.kind.level for cause in accepted}
        if count < MORE and levels_of_round == {"warning"}:
            break
        if not listed or "error" in levels_of_round - levels:
            listed = ranking.listed()
        levels |= levels_of_round
        causes += accepted
    return causes, listed


def rounds(
    scene: Scene,
    rank: Callable[[Scene, Sequence[Candidate]], Ranking],
    acceptance: Acceptance,
) -> Iterator[tuple[Ranking, list[Candidate]]]:
    """Yield the explanations of a scene and the causes accepted of them, until all is sound.

    ``rank`` compares the explanations of a scene, beside the causes accepted before.
    """
    causes: list[Candidate] = []
    for _ in range(acceptance.rounds):
        ranking = rank(scene, causes)
        accepted = [] if causes else outliers(scene, ranking)
        ranking = ranking.beside(accepted)
        accepted = accepted or acceptance.accepted(ranking, causes)
        yield ranking, accepted
        if not accepted:
            break
        causes += accepted
        scene = _scene_after(accepted)


def _ranking(
    model: RigidModel,
    scene: Scene,
    before: Sequence[Candidate],
) -> Ranking:
    """Return all explanations of a scene beside the causes that were accepted before.

    The meaning of columns is asked where no cause of all samples was accepted.
    """
    idle = [cause.kind for cause in before if cause.has_no_effect]
    kinds = [kind for kind in KINDS if kind not in idle]
    ranking = ranking_of([Comparison(scene, kinds)])
    is_of_all = any(c.of_all and "samples" in c.residuals for c in before)
    if is_of_all or scene.readings is not None:
        return ranking
    is_sound = ranking.total_factor <= SURE
    causes = [
        *of_columns(model, scene, likeliest_of(ranking.candidates), sound=is_sound)
    ]
    if not is_sound:
        causes += of_stuck(model, scene)
    return ranking.beside(causes)


def _scene_after(accepted: Sequence[Candidate]) -> Scene:
    """Return the scene where causes of a kind are right, fitted anew where it turns joints."""
    first, *others = accepted
    kind = first.kind
    right = first if kind.turns is None else _turned_back(first)
    scene = right.after()
    if first.of_all and kind.noise is None:
        scene = replace(scene, floors=())  # of fits without it
    explained = list(scene.explained)
    for cause in others:
        explained += cause.after().explained[len(cause.scene.explained) :]
    return replace(scene, explained=tuple(explained))


def _turned_back(accepted: Candidate) -> Candidate:
    """Return an explanation after a fit of joints that are turned back by it.

    There its unknown stays among the nuisances: its size is known only so well.
    """
    scene, turns = accepted.scene, accepted.kind.turns
    assert turns is not None
    joint = scene.robot.joint_names.index(accepted.parameters["joint"])
    of_joint = np.eye(scene.q.shape[1])[joint]
    correction, _ = accepted.evidence.posterior(accepted.block, accepted.sigma)
    measurements = tuple(
        m.shifted(correction * turns(m.placement.positions) * of_joint)
        for m in scene.measurements
    )
    model = RigidModel(scene.robot, zeros=scene.zeros)
    fitted, _ = model.refitted(replace(scene, measurements=measurements), scene.x)
    (block,) = accepted.kind.blocks(fitted)
    return replace(accepted, scene=fitted, block=block.only([joint]))

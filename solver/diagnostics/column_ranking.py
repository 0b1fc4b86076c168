"""Hypotheses on columns, ranked by what the nominal model leaves with them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .column_hypothesis import (
    GEARS,
    NEAR_RATIO,
    RATIOS,
    ColumnHypothesis,
    couplings,
    other_orders,
    signs,
    signs_and_quarter_turns,
    signs_and_swaps,
    signs_swaps_and_ratios,
    swaps,
    two_swaps,
    unchanged,
    with_ratios,
)
from .hypotheses import SeatSamples
from .robust_fit import RigidModel

STEPS = 8
"""Steps of an offset."""
MAX_STEP = 0.2
"""Largest change of an offset in a step [rad]."""
MAX_MISTAKES = 3
"""Largest number of mistakes; with more, the model is another robot's."""
TOLERANCE = 0.02
"""Largest mean error of a correct model once the ball's place is fitted [m]."""
USUAL_OFFSET = np.deg2rad(1.5)
"""Largest offset of a joint that is no mistake [rad]."""
NEEDED = 1.5
"""Factor by which the error grows without an offset that is needed."""
TRIED = 90
"""Samples by which a hypothesis is ranked."""
SCREENED = 24
"""Samples by which combinations are compared, of which so many are ranked then."""
FEWEST = 4
"""Of each socket, at least."""
MOST_COMBINED = 6
"""Arms with more joints than this: signs are combined with a pair at most."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
PROMISING = 0.8
"""Largest share of the present error with which a hypothesis is worth a fit."""
MOST = 4
"""Hypotheses that are worth one, at most."""
OFFSETS = np.deg2rad(np.arange(-165, 181, 30))
"""Offsets from which those of each joint are sought [rad]."""


class Ranked(NamedTuple):
    """A hypothesis with the error that it leaves."""

    error: float
    """[m]."""
    hypothesis: ColumnHypothesis


@dataclass(frozen=True)
class ColumnTrials:
    """Hypotheses on some samples, judged by the nominal model with its ball put right."""

    model: RigidModel
    samples: SeatSamples

    def ranked(self, hypotheses: Iterable[ColumnHypothesis]) -> list[Ranked]:
        """Return the error that each hypothesis leaves [m], the least first."""
        candidates = list(hypotheses)
        if not candidates:
            return []
        variants = [hypothesis.apply(self.samples) for hypothesis in candidates]
        errors = self.model.nominal.errors(variants)
        return sorted(map(Ranked, errors, candidates), key=_error)

    def best(self, hypotheses: Iterable[ColumnHypothesis]) -> Ranked:
        """Return the hypothesis that leaves least."""
        first, *_ = self.ranked(hypotheses)
        return first

    @property
    def turning(self) -> list[int]:
        """Joints whose offset shows.

        A turn of the first or the last joint is one of the base frame or of the ball.
        """
        actuated = self.model.robot.actuated
        inner = range(1, len(actuated) - 1)
        return [joint for joint in inner if actuated[joint].type != "prismatic"]

    def with_best_offsets(
        self,
        starts: Sequence[ColumnHypothesis],
        joints: Sequence[Sequence[int]],
    ) -> list[ColumnHypothesis]:
        """Return hypotheses with the best offsets of as many joints each near those they have."""
        hypotheses = list(starts)
        if not starts or not joints[0]:
            return hypotheses
        columns = np.array(joints)
        of_joints = np.arange(len(starts))[:, None], columns
        for _ in range(STEPS):
            variants = [hypothesis.apply(self.samples) for hypothesis in hypotheses]
            steps = self.model.nominal.offsets(variants, columns)
            largest = np.abs(steps).max(axis=1, keepdims=True)
            offsets = np.array([hypothesis.offsets for hypothesis in hypotheses])
            offsets[of_joints] += steps * np.minimum(1.0, MAX_STEP / largest.clip(1e-9))
            pairs = zip(hypotheses, offsets, strict=True)
            hypotheses = [replace(h, offsets=of_all) for h, of_all in pairs]
        return hypotheses

    def with_best_ratio(self, start: ColumnHypothesis) -> Ranked:
        """Return a hypothesis with the best ratio of one joint beside it."""
        joints = range(len(start.order))
        return self.near_ratio(self.best(with_ratios(start, joints, RATIOS)))

    def near_ratio(self, geared: Ranked) -> Ranked:
        """Return a hypothesis with a ratio near its own; that of a gear only if clearly better."""
        (joint,) = geared.hypothesis.mistakes["ratio"]
        near = self.best(with_ratios(geared.hypothesis, [joint], NEAR_RATIO))
        is_gear = abs(geared.hypothesis.factors[joint]) in RATIOS[: 2 * len(GEARS)]
        return geared if is_gear and near.error > PROMISING * geared.error else near

    def beside_signs(
        self, of_signs: Iterable[Iterable[ColumnHypothesis]]
    ) -> list[Ranked]:
        """Return the best of hypotheses that combine signs with others, by a few samples first."""
        few = replace(self, samples=self.samples.thinned(SCREENED, FEWEST))
        screened = [few.best(hypotheses) for hypotheses in of_signs]
        screened.sort(key=_error)
        likely = [ranked.hypothesis for ranked in screened[:SCREENED]]
        return _apart(self.ranked(likely))[:2]

    def single_offsets(self) -> list[Ranked]:
        """Return the best offset of each joint by itself, the best first."""
        as_recorded = unchanged(self.model.robot)
        starts: list[ColumnHypothesis] = []
        for joint in self.turning:
            trials = [as_recorded.with_offset(joint, offset) for offset in OFFSETS]
            starts.append(self.best(trials).hypothesis)
        joints = [[joint] for joint in self.turning]
        return self.ranked(self.with_best_offsets(starts, joints))

    def several_offsets(
        self,
        starts: Sequence[ColumnHypothesis],
    ) -> list[Ranked]:
        """Return the best hypothesis with offsets of some joints, each of them needed, if any."""
        needed = self.turning
        if not starts or not self.samples.is_overdetermined(3 + len(needed)):
            return []
        error, best = self.best(self.with_best_offsets(starts, [needed] * len(starts)))
        while needed:
            fewer = [best.with_offset(joint, 0.0) for joint in needed]
            others = [[j for j in needed if j != joint] for joint in needed]
            simpler = self.best(self.with_best_offsets(fewer, others))
            if simpler.error > NEEDED * error:
                break
            error, best = simpler
            needed = [joint for joint in needed if best.offsets[joint]]
        is_usual = np.abs(best.offsets) < USUAL_OFFSET
        best = replace(best, offsets=np.where(is_usual, 0.0, best.offsets))
        mistakes = best.mistakes
        count = len(mistakes.pop("zero", ())) + len(mistakes)
        return self.ranked([best] if 0 < count <= MAX_MISTAKES else [])


def _error(ranked: Ranked) -> float:
    return ranked.error


def promising(
    model: RigidModel, samples: SeatSamples
) -> Iterator[list[ColumnHypothesis]]:
    """Yield the best hypotheses that clearly lower the error: of each kind, then combined."""
    robot = model.robot
    trials = ColumnTrials(model, samples.thinned(TRIED, FEWEST))
    as_recorded = unchanged(robot)
    now = trials.best([as_recorded]).error
    ranking = trials.ranked(signs(robot, 1))[:2]
    ranking += trials.ranked(swaps(robot))[:2]
    ranking += trials.ranked(other_orders(robot))[:1]
    ranking.append(trials.with_best_ratio(as_recorded))
    ranking += trials.ranked(couplings(robot))[:1]
    single = [] if model.zeros else trials.single_offsets()[:2]
    starts = [as_recorded, *signs(robot, 1), *swaps(robot)] if single else []
    starts += [start for _, start in single]
    ranking += single
    if min(map(_error, ranking)) > TOLERANCE / 2:
        ranking += trials.several_offsets(starts)
    if len(robot.actuated) <= MOST_SIGNS:
        ranking += trials.ranked(two_swaps(robot))[:1] + _several(trials)
    yield _likely(ranking, now)
    yield _likely(_combined(trials, starts), now)


def _likely(ranking: Iterable[Ranked], now: float) -> list[ColumnHypothesis]:
    """Return the hypotheses that are worth a fit, by the error without them [m]."""
    ascending = sorted(ranking, key=_error)
    likely = [ranked for ranked in ascending if ranked.error < PROMISING * now]
    return [ranked.hypothesis for ranked in likely[:MOST]]


def _combined(trials: ColumnTrials, starts: Sequence[ColumnHypothesis]) -> list[Ranked]:
    """Return the best hypotheses that combine signs with quarter turns, or with a ratio.

    Args:
        trials: The samples.
        starts: Hypotheses near which offsets are sought, too; none where the model has offsets.
    """
    robot = trials.model.robot
    if len(robot.actuated) > MOST_COMBINED:
        return trials.several_offsets(starts)
    quarters = signs_and_quarter_turns(robot, trials.turning)
    turned = [start for _, start in trials.beside_signs(quarters)] if starts else []
    ranking = trials.several_offsets([*starts, *turned])
    geared = trials.beside_signs(signs_swaps_and_ratios(robot))
    return ranking + [trials.near_ratio(ranked) for ranked in geared]


def _apart(ranking: Sequence[Ranked]) -> list[Ranked]:
    """Return the hypothesis of fewest signs of those that leave the same, as mirrored arms do."""
    simplest: dict[float, Ranked] = {}
    by_signs = sorted(ranking, key=lambda r: np.sum(r.hypothesis.factors < 0))
    for ranked in by_signs:
        simplest.setdefault(round(ranked.error, 9), ranked)
    return sorted(simplest.values(), key=_error)


def _several(trials: ColumnTrials) -> list[Ranked]:
    """Return the best hypotheses that combine signs, an exchanged pair and a ratio.

    Of all signs and pairs a few samples tell the best, which all samples rank.
    """
    best = trials.beside_signs(signs_and_swaps(trials.model.robot))
    geared = [trials.with_best_ratio(ranked.hypothesis) for ranked in best]
    return best + [one for one in geared if NEEDED * one.error < best[0].error]


def last_sign(model: RigidModel, samples: SeatSamples) -> list[ColumnHypothesis]:
    """Return the last joint's other sign, unless it leaves clearly more."""
    few = samples.thinned(TRIED, FEWEST)
    *_, flipped = signs(model.robot, 1)
    error, now = model.nominal.errors([flipped.apply(few), few])
    return [] if error > now / PROMISING else [flipped]

"""Columns that do not match the model's joints: signs, orders and offsets.

Hypotheses are ranked by the nominal model; the best are fitted, and their evidence is compared with
that of all other explanations.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations

import numpy as np

from ..robot import Robot
from .hypotheses import (
    KINDS,
    Candidate,
    Samples,
    Scene,
    kind_of,
    of_zero,
    sound_recordings,
)
from .robust_fit import UNEXPLAINED, RigidModel
from .stuck import STUCK

STEPS = 8
MAX_STEP = 0.2
"""Largest change of an offset in a step [rad]."""
MAX_MISTAKES = 3
"""Largest number of mistakes; with more, the model is another robot's."""
USUAL_OFFSET = np.deg2rad(1.5)
"""Largest offset of a joint that is no mistake [rad]."""
NEEDED = 1.5
"""Factor by which the error grows without an offset that is needed."""
MUCH = 3.0
"""Multiple of the expected noise from which any placement may have wrong columns."""
OF_COLUMNS = {name: kind_of(name) for name in ("sign", "swap", "order")}
OF_COLUMNS["zero"] = kind_of("zero_column")
CAUSES = (
    *(kind for kind in KINDS if kind.name != "sound"),
    *OF_COLUMNS.values(),
    STUCK,
)
"""All causes that may be reported."""
TOLERANCE = 0.02
"""Largest mean error of a correct model once the ball's place is fitted [m]."""
TRIED = 90
"""Samples by which a hypothesis is ranked."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
PROMISING = 0.8
"""Largest share of the present error with which a hypothesis is worth a fit."""
OFFSETS = np.deg2rad(np.arange(-165, 181, 30))


@dataclass(frozen=True)
class ColumnHypothesis:
    """Hypothesis that the true joint positions are q[order] * signs - offsets."""

    robot: Robot
    order: np.ndarray
    signs: np.ndarray
    offsets: np.ndarray

    def apply(self, samples: Samples) -> Samples:
        """Return samples as they would be."""
        q = samples.positions[:, self.order] * self.signs - self.offsets
        return replace(samples, positions=q)

    @property
    def mistakes(self) -> dict[str, list[int]]:
        """Joints that it blames, by ``sign``, ``swap`` and ``zero``; no kind without any."""
        joints = {
            "sign": np.flatnonzero(self.signs < 0),
            "swap": np.flatnonzero(self.order != np.arange(len(self.order))),
            "zero": np.flatnonzero(self.offsets),
        }
        return {
            kind: indices.tolist() for kind, indices in joints.items() if len(indices)
        }

    @property
    def name(self) -> str:
        """Name of the explanation: an ``order`` is a swap of more than two."""
        # Sign before swap before zero.
        first, joints = next(iter(self.mistakes.items()))
        return "order" if first == "swap" and len(joints) > 2 else first

    @property
    def text(self) -> str:
        """The mistakes, and what mends them."""
        mends = {
            "sign": "-q",
            "swap": "their columns put right",
            "zero": "that taken off",
        }
        words = " and ".join(self._words(*item) for item in self.mistakes.items())
        return f"{words}: with {' and '.join(mends[kind] for kind in self.mistakes)}"

    def _words(self, kind: str, joints: Sequence[int]) -> str:
        if kind == "swap" and len(joints) > 2:
            return (
                f"the columns look out of order: {', '.join(map(str, self.order + 1))}"
            )
        degrees = " and ".join(f"{np.rad2deg(self.offsets[j]):+.1f}" for j in joints)
        how = {"sign": "sign-flipped", "swap": "swapped"}.get(
            kind, f"off by {degrees} deg"
        )
        numbers = " and ".join(str(joint + 1) for joint in joints)
        names = ", ".join(self.robot.joint_names[joint] for joint in joints)
        look = (
            "joint {} ({}) looks {}" if len(joints) == 1 else "joints {} ({}) look {}"
        )
        return look.format(numbers, names, how)

    def with_offset(self, joint: int, offset: float) -> "ColumnHypothesis":
        """Return the same with another offset of a joint [rad]."""
        offsets = self.offsets.copy()
        offsets[joint] = offset
        return replace(self, offsets=offsets)


Ranked = tuple[float, ColumnHypothesis]
"""Error that a hypothesis leaves [m]."""


def unchanged(robot: Robot) -> ColumnHypothesis:
    """Return the hypothesis of correct columns."""
    m = len(robot.actuated)
    return ColumnHypothesis(robot, np.arange(m), np.ones(m), np.zeros(m))


def signs(robot: Robot, count: int) -> Iterator[ColumnHypothesis]:
    """Return the hypotheses that so many joints have the other sign."""
    as_recorded = unchanged(robot)
    for some in combinations(as_recorded.order, count):
        flipped = np.isin(as_recorded.order, some)
        yield replace(as_recorded, signs=np.where(flipped, -1.0, 1.0))


def swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Return the hypotheses that two columns are exchanged."""
    as_recorded = unchanged(robot)
    for i, j in combinations(as_recorded.order.tolist(), 2):
        order = as_recorded.order.copy()
        order[[i, j]] = j, i
        yield replace(as_recorded, order=order)


@dataclass(frozen=True)
class _NominalModel:
    """Hypotheses on some samples, judged by the nominal model with its ball put right."""

    model: RigidModel
    samples: Samples

    def ranked(self, hypotheses: Iterable[ColumnHypothesis]) -> list[Ranked]:
        """Return the error that each hypothesis leaves [m], the least first."""
        candidates = list(hypotheses)
        if not candidates:
            return []
        errors = self.model.nominal_errors([h.apply(self.samples) for h in candidates])
        return sorted(zip(errors, candidates, strict=True), key=_error)

    def with_best_offsets(
        self, starts: Sequence[ColumnHypothesis], joints: Sequence[Sequence[int]]
    ) -> list[ColumnHypothesis]:
        """Return hypotheses with the best offsets of as many joints each near those they have."""
        hypotheses = list(starts)
        of_joints = np.arange(len(starts))[:, None], np.array(joints)
        for _ in range(STEPS if starts and joints[0] else 0):
            variants = [h.apply(self.samples) for h in hypotheses]
            steps = self.model.nominal_offsets(variants, of_joints[1])
            largest = np.abs(steps).max(axis=1, keepdims=True)
            offsets = np.array([h.offsets for h in hypotheses])
            offsets[of_joints] += steps * np.minimum(1.0, MAX_STEP / largest.clip(1e-9))
            pairs = zip(hypotheses, offsets, strict=True)
            hypotheses = [replace(h, offsets=of_all) for h, of_all in pairs]
        return hypotheses

    def several_offsets(
        self, starts: Sequence[ColumnHypothesis], joints: Sequence[int]
    ) -> list[ColumnHypothesis]:
        """Return the best hypothesis with offsets of some joints, each of them needed, if any."""
        needed = list(joints)
        error, best = self.ranked(
            self.with_best_offsets(starts, [needed] * len(starts))
        )[0]
        while needed:
            fewer = [best.with_offset(joint, 0.0) for joint in needed]
            others = [[j for j in needed if j != joint] for joint in needed]
            error_of_fewer, simpler = self.ranked(
                self.with_best_offsets(fewer, others)
            )[0]
            if error_of_fewer > NEEDED * error:
                break
            error, best = error_of_fewer, simpler
            needed = [j for j in needed if best.offsets[j]]
        offsets = np.where(np.abs(best.offsets) < USUAL_OFFSET, 0.0, best.offsets)
        best = replace(best, offsets=offsets)
        count = int(np.count_nonzero(offsets)) + sum(
            kind != "zero" for kind in best.mistakes
        )
        return [best] if 0 < count <= MAX_MISTAKES else []


def _error(ranked: Ranked) -> float:
    return ranked[0]


def promising(model: RigidModel, samples: Samples) -> list[ColumnHypothesis]:
    """Return the best hypotheses of each kind that clearly lower the error."""
    few = samples.thinned(TRIED, 4)
    robot = model.robot
    joints = len(robot.actuated)
    nominal = _NominalModel(model, few)
    best = nominal.ranked
    as_recorded = unchanged(robot)
    ((now, _),) = best([as_recorded])
    rolled = [np.roll(as_recorded.order, k) for k in range(1, joints)]
    orders = [as_recorded.order[::-1], *rolled]
    ranking = best(signs(robot, 1))[:2]
    ranking += best(swaps(robot))[:2]
    ranking += best(replace(as_recorded, order=order) for order in orders)[:1]
    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    if not model.zeros:
        starts = list[ColumnHypothesis]()
        for j in turning:
            trials = [as_recorded.with_offset(j, offset) for offset in OFFSETS.tolist()]
            starts.append(best(trials)[0][1])
        single = best(nominal.with_best_offsets(starts, [[j] for j in turning]))[:2]
        ranking += single
        starts = [
            as_recorded,
            *signs(robot, 1),
            *swaps(robot),
            *(start for _, start in single),
        ]
        unexplained = min(map(_error, ranking)) > TOLERANCE / 2
        if unexplained and few.is_overdetermined(3 + len(turning)):
            ranking += best(nominal.several_offsets(starts, turning))
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if min(map(_error, ranking)) > TOLERANCE:
            ranking += best(signs(robot, count))[:1]
    ranking.sort(key=_error)
    return [h for error, h in ranking if error < PROMISING * now][:4]


def of_columns(
    model: RigidModel, scene: Scene, likeliest: Candidate, *, sound: bool
) -> list[Candidate]:
    """Return candidates: wrong columns of all placements, of a suspect one, or of the last joint.

    ``sound``: the recordings are explained well, and only the sign of the last joint is tried.
    """
    parameters = likeliest.parameters
    noisy = parameters["noise"] > MUCH * scene.noise
    tried: list[tuple[slice, str | None]] = [(scene.every, None)]
    for rows, measured in zip(scene.places, scene.measurements, strict=True):
        accused = noisy or parameters.get("placement") == measured.name
        if accused and not sound and len(scene.places) > 1:
            tried.append((rows, measured.name))
    candidates: list[Candidate] = []
    for rows, placement in tried:
        seats = scene.sockets[rows]
        some = Samples(scene.q[rows], seats - seats.min(), scene.samples.measured[rows])
        if not some.is_overdetermined(len(scene.parameters)):
            continue
        for hypothesis in (
            _of_last_sign(model, some) if sound else promising(model, some)
        ):
            q = scene.q.copy()
            q[rows] = hypothesis.apply(some).positions
            changed, noise = model.refitted(replace(scene, readings=q))
            if noise < UNEXPLAINED:
                candidates.append(
                    _candidate(hypothesis, changed, placement, parameters["noise"])
                )
    return candidates


def _of_last_sign(model: RigidModel, samples: Samples) -> list[ColumnHypothesis]:
    """Return the last joint's other sign, unless it leaves clearly more."""
    few = samples.thinned(TRIED, 4)
    *_, last = signs(model.robot, 1)
    turned, now = model.nominal_errors([last.apply(few), few])
    return [] if turned > now / PROMISING else [last]


def _candidate(
    hypothesis: ColumnHypothesis, changed: Scene, placement: str | None, before: float
) -> Candidate:
    """Return a hypothesis as a candidate, with the offsets of a fit that includes the geometry."""
    best = sound_recordings(changed)
    joints, offsets = (
        np.flatnonzero(hypothesis.offsets).tolist(),
        hypothesis.offsets.copy(),
    )
    for block in of_zero(changed) if joints and placement is None else ():
        columns = block.columns[joints, :, 0].T
        together = replace(block, columns=columns[None])
        excess, _ = best.evidence.posterior(together, best.sigma)
        offsets[joints] -= excess
    hypothesis = replace(hypothesis, offsets=offsets)
    names, after = hypothesis.robot.joint_names, best.sigma
    blamed = chain.from_iterable(hypothesis.mistakes.values())
    parameters: dict[str, object] = {
        "joints": ", ".join(names[joint] for joint in blamed),
        "offsets": hypothesis.offsets.tolist(),
        "order": hypothesis.order.tolist(),
    }
    if placement is not None:
        parameters["placement"] = placement
    gain = "needs no other cause"
    if after < 0.9 * before:
        gain = f"falls from {1e3 * before:.2g} to {1e3 * after:.2g} mm"
    form = f"{hypothesis.text} the error {gain}"
    kind = replace(
        OF_COLUMNS[hypothesis.name],
        form=form.replace("{", "{{").replace("}", "}}"),
        advice="; ".join(OF_COLUMNS[mistake].advice for mistake in hypothesis.mistakes),
    )
    prior = float(np.log(kind.prior / len(names)))
    return best.as_cause(kind, parameters, prior)

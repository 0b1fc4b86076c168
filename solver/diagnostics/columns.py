"""Columns that are not the model's joints: which signs, orders and offsets are worth a fit.

A hypothesis on columns is far from linear. The model as it is, but for its ball, sorts them; fits
to the best of each kind then have their evidence compared with all other explanations.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ..results import Hypothesis
from .column_hypotheses import (
    ADVICE,
    ColumnHypothesis,
    several_offsets,
    signs,
    swaps,
    unchanged,
    with_best_offsets,
)
from .hypotheses import KINDS, ONLY_SOUND, Comparison, Kind, Scene, of_zero
from .hypothesis import Finding, Option
from .robust_fit import ABOUT, FEW, UNEXPLAINED, RigidModel, Samples

MUCH = 3.0
"""Noise, beside what is expected, from which any placement may have wrong columns."""
OF_COLUMNS = {"sign": 0.05, "swap": 0.03, "order": 0.02, "zero": 0.01}
"""Prior probabilities of mistakes in the columns."""
TELL = "read one pose at the arm, and compare it with its row"
"""Step that tells them from others."""
CAUSES = (
    *(kind for kind in KINDS if kind.name != "sound"),
    *(Kind(n, p, lambda _: "", ADVICE[n], TELL) for n, p in OF_COLUMNS.items()),
)
"""All that may be told."""
TOLERANCE = 0.02
"""A right model is off by less than this on average, once the ball's place is fitted [m]."""
TRIED = 90
"""Samples used to try a hypothesis."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
PROMISING = 0.8
"""Share of the error as it is that a hypothesis worth a fit leaves at most."""
OFFSETS = np.deg2rad(np.arange(-165, 181, 30))

Scored = tuple[float, ColumnHypothesis]
"""A hypothesis, and the error that the model as it is has with it [m]."""


def promising(model: RigidModel, samples: Samples) -> list[ColumnHypothesis]:
    """Return the best hypotheses of each kind, if they leave clearly less than what is there."""
    few = samples.thinned(TRIED, 4)
    robot, right = model.robot, unchanged(model.robot)
    joints = len(robot.actuated)
    now = model.nominal_error(few)

    def best(hypotheses: Iterable[ColumnHypothesis], count: int = 1) -> list[Scored]:
        scored = [(model.nominal_error(h.apply(few)), h) for h in hypotheses]
        return sorted(scored, key=lambda one: one[0])[:count]

    found = [*best(signs(robot, 1), 2), *best(swaps(robot), 2), *best(_orders(right))]
    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    if not model.zeros:
        starts = [best(right.with_offset(j, o) for o in OFFSETS.tolist())[0][1] for j in turning]
        single = best(
            (with_best_offsets(model, few, s, np.flatnonzero(s.offsets).tolist()) for s in starts),
            2,
        )
        found += single
        starts = [right, *signs(robot, 1), *swaps(robot), *(one for _, one in single)]
        if min(found, key=lambda one: one[0])[0] > TOLERANCE / 2 and few.is_overdetermined(
            3 + len(turning)
        ):
            several = several_offsets(model, few, starts, turning)
            found += best([several] if several is not None else [])
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if min(found, key=lambda one: one[0])[0] > TOLERANCE:
            found += best(signs(robot, count))
    found.sort(key=lambda one: one[0])
    return [h for error, h in found if error < PROMISING * now][:4]


def _last_sign(model: RigidModel, samples: Samples) -> list[ColumnHypothesis]:
    """Return the last joint's other sign, unless the model as it is leaves clearly more with it."""
    few = samples.thinned(TRIED, 4)
    *_, last = signs(model.robot, 1)
    worse = model.nominal_error(last.apply(few)) > model.nominal_error(few) / PROMISING
    return [] if worse else [last]


def _orders(right: ColumnHypothesis) -> Iterable[ColumnHypothesis]:
    """Return the hypotheses that all columns come in another order: turned round, or shifted."""
    m = len(right.order)
    for order in [right.order[::-1], *(np.roll(right.order, k) for k in range(1, m))]:
        yield ColumnHypothesis(right.robot, order, right.signs, right.offsets)


def of_columns(model: RigidModel, scene: Scene, likeliest: Option, *, sound: bool) -> list[Option]:
    """Return wrong columns of all, or of the one accused; of sound ones the last joint's sign."""
    told = dict[str, Any](likeliest.finding(1.0).hypothesis.parameters)
    tried: list[tuple[slice, str | None]] = [(slice(0, len(scene.q)), None)]
    for rows, measured in zip(scene.places, scene.measurements, strict=True):
        accused = told.get("placement") == measured.name or told["noise"] > MUCH * scene.noise
        if accused and not sound and len(scene.places) > 1:
            tried.append((rows, measured.name))
    found: list[Option] = []
    for rows, placement in tried:
        some = Samples(scene.q[rows], scene.sockets[rows] - scene.sockets[rows].min())
        if not some.is_overdetermined(len(scene.parameters)):
            continue
        for wrong in _last_sign(model, some) if sound else promising(model, some):
            q = scene.q.copy()
            q[rows] = wrong.apply(some).positions
            fit = model.fit(Samples(q, scene.sockets).thinned(ABOUT, FEW))
            if fit.noise < UNEXPLAINED:
                changed = replace(scene, x=fit.x, centres=fit.centres, readings=q)
                found.append(_option(wrong, changed, placement, told["noise"]))
    return found


def _option(
    wrong: ColumnHypothesis, changed: Scene, placement: str | None, before: float
) -> Option:
    """Return one hypothesis as an explanation, its offsets those beside a fit of the geometry."""
    comparison = Comparison(changed, ONLY_SOUND)
    (best,) = comparison.candidates
    joints, offsets = np.flatnonzero(wrong.offsets).tolist(), wrong.offsets.copy()
    for block in of_zero(changed) if joints and placement is None else ():
        columns = block.columns[joints, :, 0].T[None]
        left = comparison.evidence.posterior(replace(block, columns=columns), best.sigma)[0]
        offsets[joints] -= left
    wrong = replace(wrong, offsets=offsets)
    names, after = wrong.robot.joint_names, best.sigma
    parameters: dict[str, Any] = {
        "joints": ", ".join(names[j] for joints in wrong.mistakes.values() for j in joints),
        "offsets": wrong.offsets.tolist(),
        "order": wrong.order.tolist(),
        "noise": after,
        **({} if placement is None else {"placement": placement}),
    }

    def finding(probability: float) -> Finding:
        gain = f"falls from {1e3 * before:.2g} to {1e3 * after:.2g} mm"
        text = f"{wrong.text} the error {gain if after < 0.9 * before else 'needs no other cause'}"
        hypothesis = Hypothesis(wrong.name, probability, parameters, text, wrong.advice, TELL)
        return Finding(hypothesis, "swap" if wrong.name == "order" else wrong.name, "error")

    log = best.log_evidence + float(np.log(OF_COLUMNS[wrong.name] / len(names)))
    return Option(wrong.name, log, {"samples"}, finding, lambda: changed)

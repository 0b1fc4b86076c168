"""Findings on recordings, by what their fit says of them: movements, and the arm's size."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...errors import fixed
from ..diagnostics import SIZE_BY_DISTANCE, by_fit, where_of
from ..identification.data import CLOCKS, Observations
from ..identification.inference import FitPosterior
from ..identification.model import BALL, BASE, Difference
from ..identification.selection import follows_order, orders, set_ups
from ..results import Diagnostic, Fit, Hypothesis, Scale, Study
from .fit import CalibrationProblem

WORDS = {
    "step": "{} moved by {}, {}",
    "drift": "{} drifted steadily by {}",
    "slow": "{} drifted to and fro by {}{}",
}
HOLDS = 0.01
"""Share within which a fit has the arm's size: no distance is then wrong by far more."""
DISTANCE = "scale"
"""Code of findings of a wrong distance."""
DIFFERENCE = "movement"
"""Code of what differs between places, for which the fit has an unknown."""
MENDED = "to be more exact, solve only what was recorded after it"
BASES = {"sockets": "its socket base", "points": "the instrument or the arm's foot"}
STEADY = {
    "sockets": "fasten it before you record again",
    "points": "let instrument and arm stand still and warm before you measure again",
}


def findings(
    fit: Fit, problem: CalibrationProblem, scale: Scale, distorted: Sequence[str]
) -> tuple[Diagnostic, ...]:
    """Return the findings from before the fit, and the movements of places that it found."""
    diagnostics = list(problem.checks)
    full = fit.full
    if full is not None:
        for k in range(len(full.objective.differences)):
            diagnostics += _told(problem, full, k)
    by_distance = any(h.name in SIZE_BY_DISTANCE for h in problem.hypotheses[:1])
    if not distorted and abs(scale.value) < HOLDS and not by_distance:
        # the fit refutes them: seen beside what is more probable, as another version's URDF
        diagnostics = [
            d for d in diagnostics if d.code != DISTANCE or d.level == "error"
        ]
    sized = hypotheses(fit, problem, scale, distorted)
    return reworded(diagnostics, problem.hypotheses, sized)


def reworded(
    diagnostics: Sequence[Diagnostic],
    before: Sequence[Hypothesis],
    after: Sequence[Hypothesis],
) -> tuple[Diagnostic, ...]:
    """Return findings, those that are an explanation in its new words."""
    pairs = zip(before, after, strict=True)
    texts = {old.text: new.text for old, new in pairs}
    return tuple(replace(d, text=texts.get(d.text, d.text)) for d in diagnostics)


def hypotheses(
    _: Fit, problem: CalibrationProblem, scale: Scale, distorted: Sequence[str]
) -> tuple[Hypothesis, ...]:
    """Return the explanations of the recordings, those of the arm's size by that of the fit."""
    return problem.hypotheses if distorted else sized_hypotheses(problem, scale)


def sized_hypotheses(
    problem: CalibrationProblem, scale: Scale
) -> tuple[Hypothesis, ...]:
    """Return explanations of recordings, those of the arm's size by that of a fit.

    Where other lengths than those between a base's sockets are known, a fit follows these, and
    where something else is more probable, it may be why the fit made the arm larger.
    """
    by_bases_alone = all(m.kind == "sockets" for m in problem.measurements)
    if problem.options.distances or problem.options.located or not by_bases_alone:
        return problem.hypotheses
    if all(h.name not in SIZE_BY_DISTANCE for h in problem.hypotheses[:1]):
        return problem.hypotheses
    return tuple(by_fit(h, scale.value) for h in problem.hypotheses)


def _told(
    problem: CalibrationProblem, fit: FitPosterior, k: int
) -> Iterator[Diagnostic]:
    """Yield the k-th difference of a fit as a diagnostic; none for targets put on anew."""
    difference = fit.objective.differences[k]
    if difference in set_ups(fit.data):
        return
    name = difference.placements[0]
    measured = next(m for m in problem.measurements if m.name == name)
    text = _in_words(fit, k, BASES[measured.kind])
    if difference.at:
        by_clock = np.argsort(measured.clocks[:, CLOCKS.index(difference.clock)])
        ranks: list[int] = measured.order[by_clock].tolist()
        names = [measured.placement.samples[rank].named for rank in ranks]
        last = int(min(difference.until, len(names))) - 1
        text = text.format(first=names[int(difference.at)], last=names[last])
    if follows_order(difference) and len(orders(fit.data, name)) > 1:
        first = measured.sockets[-int(difference.clock == "reverse")]
        text += f" (socket {first} taken as recorded first)"
    text += "; the fit corrects this, so keep these samples"
    advice = STEADY[measured.kind] if difference.part == BASE else MENDED
    yield Diagnostic("warning", DIFFERENCE, where_of([measured]), text, advice)


def _in_words(posterior: FitPosterior, k: int, base: str) -> str:
    """Return the k-th difference of a fit in words, which call what holds the sockets ``base``."""
    objective, data = posterior.objective, posterior.data
    difference = objective.differences[k]
    begin = sum(objective.sizes[:k])
    of_difference = slice(begin, begin + objective.sizes[k])
    shifts = objective.by_differences[:, :, of_difference]
    size = objective.model.size
    members = slice(size + begin, size + of_difference.stop)
    unknowns = posterior.state.x[members]
    variances = np.diag(posterior.whole[members, members])
    deviation = float(variances.max()) ** 0.5
    since = _since(difference, data)
    if difference.part == BASE:
        course = (shifts @ unknowns)[data.rows_of(difference.placements[0])]
        moved = float(np.linalg.norm(np.ptp(course, axis=0)))
        amount = _millimetres(moved, deviation)
        words = WORDS[difference.course].format(base, amount, since)
    elif difference.part == BALL:
        of_placements = unknowns.reshape(len(difference.weights), -1)
        sizes = np.linalg.norm(of_placements[:, :3], axis=1)
        amount = _millimetres(float(sizes.max()), deviation)
        words = f"the ball sits {amount} elsewhere on its flange {since}"
    else:
        zero, error = np.rad2deg([unknowns[0], deviation]).tolist()
        amount = f"{fixed(abs(zero), 2)} +- {fixed(error, 2)} deg"
        way = "more" if zero > 0 else "less"
        words = f"{difference.part} reads {amount} {way} {since}"
    return words


def _millimetres(size: float, deviation: float) -> str:
    """Return a size [m] in words."""
    return f"{fixed(1e3 * size, 2)} +- {fixed(1e3 * deviation, 2)} mm"


def _since(difference: Difference, data: Observations) -> str:
    """Return in words where a step is; {{first}} stands for a sample."""
    first, last = difference.placements[0], difference.placements[-1]
    if difference.course == "slow":
        return ", with temperature" * (difference.clock == "temperature")
    if difference.course == "each":
        return "from placement to placement"
    if difference.until < np.inf:
        return "from {first} to {last} only"
    if difference.at:
        return "from {first} on"
    if last == data.placements[-1]:
        return f"from {first} on"
    return f"in {first}" if first == last else f"from {first} to {last}"


READS = ("scale", "distorted")
CHECKS = Study("checks", findings, READS, needs_posterior=False)
HYPOTHESES = Study("hypotheses", hypotheses, READS, needs_posterior=False)

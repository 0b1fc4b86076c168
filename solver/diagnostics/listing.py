"""Explanations by their probabilities, the most probable first, and the first of them in words."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..bayes.model import probabilities_by_name
from ..results import Hypothesis
from .hypotheses import Candidate

SECOND = 0.1
"""Probability from which the second explanation is reported with the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
ALIKE = 10.0
"""Difference of chi-square below which explanations of few unknowns fit as well: those with more
are less probable by their number alone, and both are named."""
FEW_UNKNOWNS = 3
"""Unknowns that such an explanation has at most."""


def shares_of(candidates: Sequence[Candidate]) -> dict[str, float]:
    """Return the probability of each name, by the logarithms of the evidence."""
    names = [candidate.kind.name for candidate in candidates]
    logs = np.array([candidate.log_evidence for candidate in candidates])
    return probabilities_by_name(names, logs)


def listed_of(
    candidates: Sequence[Candidate],
    shares: Mapping[str, float],
) -> tuple[Hypothesis, ...]:
    """Return the best explanation of each name, the most probable first."""
    # Of candidates that are equal but for rounding the first counts.
    best: dict[str, Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: -round(c.log_evidence, 6)):
        best.setdefault(candidate.kind.name, candidate)
    likely = [name for name in best if shares[name] >= LISTED]
    likely.sort(key=lambda name: -shares[name])
    first = best[likely[0]]
    rivals = [name for name in best if _fits_as_well(best[name], first)]
    others = [name for name in rivals if name not in likely]
    hypotheses: list[Hypothesis] = []
    for name in likely + others:
        hypothesis = best[name].hypothesis(shares[name])
        hypotheses.append(replace(hypothesis, fits_as_well=name in rivals))
    return tuple(hypotheses)


def _fits_as_well(candidate: Candidate, first: Candidate) -> bool:
    """Tell whether a candidate of few unknowns leaves much the same chi-square as the first."""
    evidence = first.evidence
    if candidate is first or candidate.evidence is not evidence:
        return False
    gains: list[float] = []
    for block in candidate.block, first.block:
        if not 0 < block.unknowns <= FEW_UNKNOWNS:
            return False
        gains.append(evidence.chi_square(block, first.sigma))
    gain, best = gains
    return abs(gain - best) < ALIKE < 0.5 * best


def cause(hypotheses: Sequence[Hypothesis]) -> str:
    """Return the first cause in words, and the second where it may be that; empty for none."""
    if not hypotheses or hypotheses[0].name == "sound":
        return ""
    first, *alternatives = hypotheses
    words = (
        f"most probable cause ({_percent(first.probability)}): {first.text}; "
        f"{first.advice} (docs: causes/{first.name})"
    )
    for second in alternatives:
        is_likely = second.probability > SECOND or second.fits_as_well
        if is_likely and second.name != "sound":
            how = _percent(second.probability)
            if second.fits_as_well:
                how = "it fits as well"
            step = first.tell or second.tell
            words += f". It cannot be told from this ({how}): {second.text}"
            return f"{words}; to tell them, {step}"
    return words


def _percent(share: float) -> str:
    return f"{100 * min(share, 0.999):.3g} %"

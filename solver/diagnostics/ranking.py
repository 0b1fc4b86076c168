"""Explanations of a scene, ranked by their evidence, and the first of them in words."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..identification.model import probabilities_by_name
from ..results import Hypothesis
from .hypotheses import Candidate, Comparison, likeliest_of

SECOND = 0.1
"""Probability from which the second explanation is reported with the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
ALIKE = 10.0
"""Difference of chi-square below which explanations of few unknowns fit as well: those with more
are less probable by their number alone, and both are named."""
FEW_UNKNOWNS = 3
"""Unknowns that such an explanation has at most."""


@dataclass(frozen=True)
class Ranking:
    """Causes, compared with the hypothesis of sound recordings."""

    candidates: Sequence[Candidate]
    """Sound recordings, then all causes."""
    total_factor: float
    """Log Bayes factor of all causes together, over all arms that may be."""

    @property
    def sound(self) -> Candidate:
        """Nothing is wrong."""
        return self.candidates[0]

    @property
    def best(self) -> Candidate:
        """The most probable cause."""
        return likeliest_of(self.candidates[1:])

    @cached_property
    def shares(self) -> dict[str, float]:
        """Probability of each kind, by its name."""
        names = [candidate.kind.name for candidate in self.candidates]
        logs = np.array([candidate.log_evidence for candidate in self.candidates])
        return probabilities_by_name(names, logs)

    def factor(self, candidate: Candidate) -> float:
        """Return the log Bayes factor of a candidate against sound recordings."""
        return candidate.log_evidence - self.sound.log_evidence

    def beside(self, causes: Sequence[Candidate]) -> "Ranking":
        """Return the ranking with further causes of the same arm."""
        factors = [self.factor(candidate) for candidate in causes]
        total = np.logaddexp.reduce([self.total_factor, *factors])
        return Ranking([*self.candidates, *causes], float(total))

    def listed(self) -> tuple[Hypothesis, ...]:
        """Return the best explanation of each kind, the most probable first."""
        # Of candidates that are equal but for rounding the first counts.
        best: dict[str, Candidate] = {}
        descending = sorted(self.candidates, key=lambda c: -round(c.log_evidence, 6))
        for candidate in descending:
            best.setdefault(candidate.kind.name, candidate)
        likely = [name for name in best if self.shares[name] >= LISTED]
        likely.sort(key=lambda name: -self.shares[name])
        first = best[likely[0]]
        rivals = [name for name in best if _fits_as_well(best[name], first)]
        others = [name for name in rivals if name not in likely]
        hypotheses: list[Hypothesis] = []
        for name in likely + others:
            hypothesis = best[name].hypothesis(self.shares[name])
            hypotheses.append(replace(hypothesis, fits_as_well=name in rivals))
        return tuple(hypotheses)


def ranking_of(comparisons: Iterable[Comparison]) -> Ranking:
    """Return the explanations by the most probable arm, and their evidence over all arms."""
    rankings: list[Ranking] = []
    for comparison in comparisons:
        sound, *causes = comparison.candidates
        rankings.append(Ranking([sound], -math.inf).beside(causes))
    of_sound = np.array([ranking.sound.log_evidence for ranking in rankings])
    of_causes = of_sound + [ranking.total_factor for ranking in rankings]
    of_arms = np.logaddexp(of_sound, of_causes)
    total = np.logaddexp.reduce(of_causes) - np.logaddexp.reduce(of_sound)
    return replace(rankings[int(np.argmax(of_arms))], total_factor=float(total))


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

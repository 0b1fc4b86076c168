"""Explanations of a scene, ranked by their evidence, and the first of them in words."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..identification.model import probabilities_by_name
from ..results import Hypothesis
from .hypotheses import (
    KINDS,
    Candidate,
    Comparison,
    Scene,
    likeliest_of,
    nearest_sockets,
    sound_recordings,
)

SECOND = 0.1
"""Probability from which the second explanation is reported with the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
OF_LENGTH = {"distance", "base_between"}
"""Explanations that are one where there is a single placement."""
ALIKE = 10.0
"""Difference of chi-square below which explanations of few unknowns fit as well: those with more
are less probable by their number alone, and both are named."""
FEW_UNKNOWNS = 3
"""Unknowns that such an explanation has at most."""
OUTLIER = next(kind for kind in KINDS if kind.name == "ball_sample")
HIDDEN = "hidden"
"""Parameter of samples that hide each other, which no robust fit needs: they are left out."""
FAR = 20.0
"""Multiple of the typical error from which a sample is looked at."""
LEAST = 3e-3
"""Error below which it is not [m]."""
MOST = 0.25
"""Share of the samples beyond which they are no outliers."""


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
        return probabilities_by_name(
            names, np.array([candidate.log_evidence for candidate in self.candidates])
        )

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
        return tuple(
            replace(
                best[name].hypothesis(self.shares[name]),
                fits_as_well=name in rivals,
            )
            for name in dict.fromkeys([*likely, *rivals])
        )


def ranking_of(comparisons: Iterable[Comparison]) -> Ranking:
    """Return the explanations by the most probable arm, and their evidence over all arms."""
    rankings = [
        Ranking(comparison.candidates[:1], -math.inf).beside(comparison.candidates[1:])
        for comparison in comparisons
    ]
    of_sound = np.array([ranking.sound.log_evidence for ranking in rankings])
    of_causes = of_sound + [ranking.total_factor for ranking in rankings]
    of_arms = np.logaddexp(of_sound, of_causes)
    total = np.logaddexp.reduce(of_causes) - np.logaddexp.reduce(of_sound)
    return replace(rankings[int(np.argmax(of_arms))], total_factor=float(total))


def _fits_as_well(
    candidate: Candidate,
    first: Candidate,
) -> bool:
    """Tell whether a candidate of few unknowns leaves much the same chi-square as the first."""
    evidence = first.evidence
    if candidate is first or candidate.evidence is not evidence:
        return False
    blocks = candidate.block, first.block
    if not all(0 < block.unknowns <= FEW_UNKNOWNS for block in blocks):
        return False
    gain, best = [evidence.chi_square(block, first.sigma) for block in blocks]
    return abs(gain - best) < ALIKE < 0.5 * best


def cause(hypotheses: Sequence[Hypothesis]) -> str:
    """Return the first cause in words, and the second where it may be that; empty for none."""
    if not hypotheses or hypotheses[0].name == "sound":
        return ""
    first, *alternatives = hypotheses
    words = (
        f"most probable cause of the errors ({_percent(first.probability)}): {first.text}; "
        f"{first.advice} (page causes/{first.name} of the docs)"
    )
    for second in alternatives:
        is_likely = second.probability > SECOND or second.fits_as_well
        is_same = second.fits_as_well and {first.name, second.name} == OF_LENGTH
        if is_likely and second.name != "sound" and not is_same:
            how = f"Or, with {_percent(second.probability)}"
            if second.fits_as_well:
                how = "These data fit another cause as well"
            step = first.tell or second.tell
            return f"{words}. {how}: {second.text}. To decide, {step}"
    return words


def _percent(share: float) -> str:
    return f"{100 * min(share, 0.999):.3g} %"


def outliers(
    scene: Scene,
    ranking: Ranking,
) -> list[Candidate]:
    """Return samples that are off, if several together are more probable than all single causes.

    Args:
        scene: The recordings about a robust fit.
        ranking: All causes by themselves.
    """
    # the distance of each sample from the place of its seat, shape (N,) [m]
    errors = np.linalg.norm(scene.seats - scene.centres[scene.sockets], axis=1)
    # the samples that are far from the place of their seat, the farthest first
    _, elsewhere = nearest_sockets(scene)
    limit = max(LEAST, FAR * float(np.median(errors)))
    farthest = np.argsort(-errors)
    is_off = (errors > limit) & ~elsewhere
    rows = farthest[is_off[farthest]].tolist()
    if not 2 <= len(rows) <= MOST * len(scene.q):
        return []
    causes = [_cause(ranking.sound, row, errors[row]) for row in rows]
    terms = [cause.after().explained[-1] for cause in causes]
    sound = sound_recordings(_without(causes, terms))
    log_prior = len(rows) * math.log(OUTLIER.prior / len(scene.q))
    together = replace(sound, log_evidence=sound.log_evidence + log_prior)
    if ranking.factor(together) < max(ranking.total_factor, 0.0):
        return []
    # the size of each follows beside all others
    return [
        replace(
            outlier,
            evidence=sound_recordings(
                _without(causes[:i] + causes[i + 1 :], terms[:i] + terms[i + 1 :])
            ).evidence,
            sigma=sound.sigma,
            log_evidence=together.log_evidence,
        )
        for i, outlier in enumerate(causes)
    ]


def _without(
    causes: Sequence[Candidate],
    terms: Sequence[tuple[slice, np.ndarray, np.ndarray]],
) -> Scene:
    """Return the scene in which some causes are right, by what each of them explains."""
    scene = causes[0].after()
    return replace(scene, explained=(*scene.explained, *terms[1:]))


def _cause(
    sound: Candidate,
    row: int,
    error: float,
) -> Candidate:
    """Return the cause that a sample is off, typically by its error [m], among sound recordings."""
    scene = sound.scene
    place = next(i for i, rows in enumerate(scene.places) if row < rows.stop)
    block = list(OUTLIER.blocks(scene))[place]
    only = block.only([row - scene.places[place].start])
    parameters = [{**only.parameters[0], HIDDEN: True}]
    of_size = replace(only, parameters=parameters, widths=(float(error),))
    return replace(sound, kind=OUTLIER, block=of_size)

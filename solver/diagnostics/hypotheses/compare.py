"""Comparison of all explanations by Bayes' rule, and of what is left once one was found."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .evidence import LinearEvidence
from .kinds import Block, Kind, NoisePrior
from .scene import Scene
from .table import KINDS

LARGEST, HALVES = 0.3, 1.6
"""Largest noise thought of [m], and the factor from one trial of it to the next."""
SPAN, STEPS = 0.2, 11
"""Range of the logarithm of the noise, each side of the best, over which it is averaged, and the
number of trials in it."""
REFINED = 3
"""Candidates of each kind that are looked at closely."""


@dataclass(frozen=True)
class Candidate:
    """One explanation with its numbers, and its evidence."""

    kind: Kind
    block: Block
    log_evidence: float
    """Prior probability and likelihood, their logarithm."""
    sigma: float
    """Most probable noise [m]."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Of the block's only candidate."""
        return self.block.parameters[0]


class Comparison:
    """All explanations of a scene, each kind with its best candidates.

    Args:
        scene: The recordings as a linear model.
        kinds: The explanations.
    """

    def __init__(self, scene: Scene, kinds: Sequence[Kind] = KINDS) -> None:
        self.scene = scene
        self.evidence = LinearEvidence(scene.residuals, scene.nuisances)
        least = max(scene.noise / 4, 1e-6)
        trials = np.geomspace(least, LARGEST, int(math.log(LARGEST / least, HALVES)) + 2)
        base = self.evidence.log_likelihood(trials)
        last = int(np.argmax(base)) + 2
        self._trials, self._base = trials[:last], base[:last]
        self.candidates = [c for kind in kinds for c in self._of(kind)]

    def _prior(self, kind: Kind) -> NoisePrior:
        if kind.noise is not None:
            return kind.noise(self.scene)
        return NoisePrior(1.5 * self.scene.noise, self.scene.noise_width)

    def _of(self, kind: Kind) -> Iterator[Candidate]:
        """Return the best candidates of a kind."""
        blocks = list(kind.blocks(self.scene))
        total = sum(len(block.parameters) for block in blocks)
        noise = self._prior(kind)
        prior = self._base + noise.log_density(self._trials)
        rough: list[tuple[float, int, int, float]] = []
        for b, block in enumerate(blocks):
            terms = self.evidence.terms(block)
            best = self.evidence.log_ratios(block, terms, self._trials).max(axis=1)
            best = best + prior[:, None]
            for c, at in enumerate(np.argmax(best, axis=0).tolist()):
                rough.append((float(best[at, c]), b, c, float(self._trials[at])))
        rough.sort(key=lambda one: -one[0])
        kept = [r for r in rough if r[0] > rough[0][0] - 30]
        for _, b, c, sigma in kept[: 60 if kind.several else REFINED]:
            block = blocks[b].only([c])
            log, sigma = self._refined(block, noise, sigma)
            yield Candidate(kind, block, log + float(np.log(kind.prior / total)), sigma)

    def _refined(self, block: Block, noise: NoisePrior, sigma: float) -> tuple[float, float]:
        """Return the evidence of a candidate, averaged over the noise, and its likeliest noise."""
        terms, logs = self.evidence.terms(block), np.zeros(1)
        for span in (0.5 * float(np.log(HALVES)), SPAN):
            trials = sigma * np.exp(span * np.linspace(-1, 1, STEPS))
            ratios = self.evidence.log_ratios(block, terms, trials)[:, :, 0]
            top = ratios.max(axis=1, keepdims=True)
            logs = (top + np.log(np.exp(ratios - top).sum(axis=1, keepdims=True)))[:, 0]
            logs = logs + self.evidence.log_likelihood(trials) + noise.log_density(trials)
            sigma = float(trials[int(np.argmax(logs))])
        best = float(logs.max())
        step = 2 * SPAN / (STEPS - 1)
        return best + float(np.log(step * np.sum(np.exp(logs - best)))), sigma

    def found(self, candidate: Candidate) -> tuple[Mapping[str, Any], str]:
        """Return the numbers of a candidate, and its words."""
        kind, parameters = candidate.kind, {**candidate.parameters, "noise": candidate.sigma}
        if candidate.block.columns.shape[2]:
            values = self.evidence.posterior(candidate.block, candidate.sigma)[0]
            parameters = {**kind.values(self.scene, parameters, values), "noise": candidate.sigma}
        return parameters, kind.text(parameters)


def probabilities(logs: Sequence[float]) -> np.ndarray:
    """Return the probabilities of explanations by the logarithms of their evidence."""
    values = np.array(logs)
    odds: np.ndarray = np.exp(values - values.max())
    return odds / odds.sum()


def explained(scene: Scene, candidate: Candidate) -> Scene:
    """Return the scene with a candidate among what may be off, its centres put right."""
    block = candidate.block
    shift = None if block.shift is None else block.shift[0]
    one = (block.rows, block.columns[0] * max(block.widths), shift)
    return replace(scene, found=(*scene.found, one)).recentred(candidate.sigma)

"""Comparison of all explanations by Bayes' rule, and of what is left once one was found."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .evidence import INDEPENDENT, LinearEvidence
from .kinds import Block, Kind, NoisePrior
from .scene import Scene
from .table import KINDS

LARGEST, HALVES = 0.3, 1.6
"""Largest noise thought of [m], and the factor from one trial of it to the next."""
STEP, SPAN = 0.04, 11
"""Step of the logarithm of the noise over which it is averaged, and steps each side of the best of
the former trials."""
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
    """All explanations of a scene, each kind with its best; a share of the errors counts."""

    def __init__(
        self, scene: Scene, kinds: Sequence[Kind] = KINDS, share: float = INDEPENDENT
    ) -> None:
        self.scene = scene
        self.evidence = LinearEvidence(scene.residuals, scene.nuisances, share, scene.whitening)
        least = max(scene.noise / 4, 1e-6)
        trials = np.geomspace(least, LARGEST, int(math.log(LARGEST / least, HALVES)) + 2)
        base = self.evidence.log_likelihood(trials)
        last = int(np.argmax(base)) + 2
        self._trials, self._base = trials[:last], base[:last]
        self._close: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self.candidates = [c for kind in kinds for c in self._of(kind)]

    def _prior(self, kind: Kind) -> NoisePrior:
        if kind.noise is not None:
            return kind.noise(self.scene)
        # servos never have much less
        below = not self.scene.zeros
        return NoisePrior(1.5 * self.scene.noise, self.scene.noise_width, below=below)

    def _of(self, kind: Kind) -> Iterator[Candidate]:
        """Return the best candidates of a kind: by few trials of the noise, then by many."""
        blocks = list(kind.blocks(self.scene))
        total = sum(len(block.parameters) for block in blocks)
        noise = self._prior(kind)
        prior = self._base + noise.log_density(self._trials)
        terms = [self.evidence.terms(block) for block in blocks]
        rough: list[tuple[float, int, int, int]] = []
        for b, block in enumerate(blocks):
            logs = self.evidence.log_ratios(block, terms[b], self._trials).max(axis=1)
            logs = logs + prior[:, None]
            best = np.argmax(logs, axis=0)
            values: list[float] = logs[best, np.arange(len(best))].tolist()
            rough += [(v, b, at, c) for c, (v, at) in enumerate(zip(values, best, strict=True))]
        rough.sort(reverse=True)
        kept = [r for r in rough if r[0] > rough[0][0] - 30][: 60 if kind.several else REFINED]
        for (b, at), some in itertools.groupby(sorted(r[1:] for r in kept), key=lambda r: r[:2]):
            block, own = blocks[b], [c for *_, c in some]
            trials, base = self._near(at)
            ratios = self.evidence.log_ratios(block.only(own), terms[b].only(own), trials)
            logs = _sum_of_exp(ratios, axis=1) + (base + noise.log_density(trials))[:, None]
            found = _sum_of_exp(logs, axis=0) + math.log(STEP * kind.prior / total)
            for c, log, best in zip(own, found.tolist(), np.argmax(logs, axis=0), strict=True):
                yield Candidate(kind, block.only([c]), log, float(trials[best]))

    def _near(self, at: int) -> tuple[np.ndarray, np.ndarray]:
        """Return close trials of the noise about a rough one, and the likelihood of each."""
        if at not in self._close:
            trials = self._trials[at] * np.exp(STEP * np.arange(-SPAN, SPAN + 1))
            self._close[at] = trials, self.evidence.log_likelihood(trials)
        return self._close[at]

    def found(self, candidate: Candidate) -> tuple[Mapping[str, Any], str]:
        """Return the numbers of a candidate, and its words."""
        kind, parameters = candidate.kind, {**candidate.parameters, "noise": candidate.sigma}
        if candidate.block.columns.shape[2]:
            values = self.evidence.posterior(candidate.block, candidate.sigma)[0]
            parameters = {**kind.values(self.scene, parameters, values), "noise": candidate.sigma}
        return parameters, kind.text(parameters)


def _sum_of_exp(logs: np.ndarray, axis: int) -> np.ndarray:
    """Return the logarithm of the sum of exponentials along an axis."""
    top = logs.max(axis=axis, keepdims=True)
    return (top + np.log(np.exp(logs - top).sum(axis=axis, keepdims=True))).squeeze(axis)


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

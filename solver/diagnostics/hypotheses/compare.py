"""Comparison of all explanations by Bayes' rule, and the scene once one was accepted."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, groupby, repeat

import numpy as np

from ...results import Hypothesis
from .evidence import INDEPENDENT, LinearEvidence
from .kinds import Block, Kind, NoisePrior, Parameters
from .scene import Scene
from .table import KINDS, ONLY_SOUND

LARGEST, HALVES = 0.3, 1.6
"""Largest noise [m], and the factor from one trial of it to the next."""
STEP, SPAN = 0.04, 11
"""Step of the logarithm of the noise over which it is averaged, and steps each side of the best of
the former trials."""
FACTORS = np.exp(STEP * np.arange(-SPAN, SPAN + 1))
TINY = 0.1
"""Largest joint position, below which another unit is likely [rad]: 4 rad, taken for degrees, are
0.07."""
REFINED, SEPARATE = 3, 60
"""Candidates of each kind whose evidence is refined, and of one of which several may be right."""
NEAR = 30.0
"""Log Bayes factor from the best, beyond which none is refined."""


@dataclass(frozen=True)
class Candidate:
    """One explanation: its numbers, its evidence, its words, and the scene where it is right."""

    kind: Kind
    block: Block
    log_evidence: float
    """Prior probability and likelihood, their logarithm."""
    sigma: float
    """Most probable noise [m]."""
    scene: Scene
    evidence: LinearEvidence
    """Of the scene without it."""

    @cached_property
    def parameters(self) -> Parameters:
        """Its names and numbers, and the noise that remains with it."""
        numbers = {**self.block.parameters[0], "noise": self.sigma}
        if self.block.unknowns:
            values = self.evidence.posterior(self.block, self.sigma)[0]
            numbers |= self.kind.values(self.scene, numbers, values)
        return numbers

    def hypothesis(self, probability: float = 1.0) -> Hypothesis:
        """Return it in words."""
        p = dict(self.parameters)
        kind = self.kind.for_points() if self.of_points else self.kind
        advice = kind.advice.format(**p)
        if all(np.abs(m.positions).max() < TINY for m in self.scene.measurements):
            advice += (
                f"; or are the angles in another unit? none is beyond {TINY:g} rad"
            )
        return Hypothesis(kind.name, probability, p, kind.text(p), advice, kind.tell)

    @property
    def of_points(self) -> bool:
        """True where it concerns points that an instrument measured, and no sockets."""
        names = self.block.parameters[0]
        place = names.get("placement")
        concerned = [m for m in self.scene.measurements if place in (None, m.name)]
        return "frame" in names or all(m.kind == "points" for m in concerned)

    @property
    def of_all(self) -> bool:
        """True where it concerns all placements, or the arm."""
        return "placement" not in self.parameters

    @property
    def has_no_effect(self) -> bool:
        """True where accepting it leaves the scene as it is, so that it would be found again."""
        return not (self.kind.noise or self.kind.scene_after or self.block.columns.size)

    @property
    def residuals(self) -> set[str]:
        """Of ``samples`` or of ``distances``, or both, that it changes."""
        if self.kind.noise is not None:
            return {"samples", "distances"}
        of_distances = self.block.rows.start >= self.scene.all_lengths.start
        return {"distances" if of_distances else "samples"}

    @property
    def shift(self) -> np.ndarray:
        """By how much it changes its rows of the residuals, beside its unknowns [m]."""
        return self.block.columns[0, :, self.block.unknowns :].sum(axis=1)

    def as_cause(
        self, kind: Kind, parameters: Parameters, log_prior: float
    ) -> "Candidate":
        """Return what changed a scene that was fitted anew, by its evidence as sound recordings."""
        return replace(
            self,
            kind=replace(kind, scene_after=_as_it_is),
            block=replace(self.block, parameters=[parameters]),
            log_evidence=self.log_evidence + log_prior,
        )

    def after(self) -> Scene:
        """Return the scene where it is right, about the centres that follow."""
        kind, block, scene = self.kind, self.block, self.scene
        if kind.noise is not None:
            return replace(scene, noise=max(scene.noise, self.sigma))
        if kind.scene_after is not None:
            return kind.scene_after(scene, block.parameters[0])
        columns = block.columns[0, :, : block.unknowns] * max(block.widths)
        explained = (*scene.explained, (block.rows, columns, self.shift))
        return replace(scene, explained=explained).recentred(self.sigma)


def _as_it_is(scene: Scene, _: object) -> Scene:
    return scene


class Comparison:
    """The best candidates of each kind of explanation; a share of the errors counts."""

    def __init__(
        self, scene: Scene, kinds: Sequence[Kind] = KINDS, share: float = INDEPENDENT
    ) -> None:
        self.scene = scene
        self.evidence = LinearEvidence(
            scene.residuals, scene.nuisances, share, scene.whitening
        )
        smallest = max(scene.noise / 4, 1e-6)
        count = int(math.log(LARGEST / smallest, HALVES)) + 2
        self._trials, self._base = self.evidence.trials(smallest, LARGEST, count)
        possible = [kind for kind in kinds if not (kind.rigid and scene.zeros)]
        self.candidates = list(chain.from_iterable(self._of(kind) for kind in possible))

    def _of(self, kind: Kind) -> Iterator[Candidate]:
        """Return the best candidates of a kind: by few trials of the noise, then by many."""
        scene = self.scene
        blocks = list(kind.blocks(scene))
        total = sum(len(block.parameters) for block in blocks)
        # the noise of servos is never much less
        usual = NoisePrior(1.5 * scene.noise, scene.noise_width, below=not scene.zeros)
        noise = usual if kind.noise is None else kind.noise(scene)
        prior = math.log(STEP * kind.prior / max(total, 1))
        for trial, few in self._likeliest(
            blocks, noise, SEPARATE if kind.separate else REFINED
        ):
            trials = trial * FACTORS
            ratios = self.evidence.log_ratios(few, trials)
            base = self.evidence.log_likelihood(trials) + noise.log_density(trials)
            logs = np.logaddexp.reduce(ratios, axis=1) + base[:, None]
            evidence = np.logaddexp.reduce(logs, axis=0) + prior
            best = trials[np.argmax(logs, axis=0)]
            for c in range(len(best)):
                yield Candidate(
                    kind,
                    few.only([c]),
                    float(evidence[c]),
                    float(best[c]),
                    scene,
                    self.evidence,
                )

    def _likeliest(
        self, blocks: Sequence[Block], noise: NoisePrior, count: int
    ) -> Iterator[tuple[float, Block]]:
        """Yield the best columns of each block by few trials, and the noise at which they are."""
        prior = self._base + noise.log_density(self._trials)
        tried: list[tuple[float, int, int, int]] = []
        for b, block in enumerate(blocks):
            ratios = self.evidence.log_ratios(block, self._trials).max(axis=1)
            logs = ratios + prior[:, None]
            evidence, best = logs.max(axis=0).tolist(), np.argmax(logs, axis=0).tolist()
            tried += zip(evidence, repeat(b), best, range(len(best)))
        tried.sort(reverse=True)
        near = [trial[1:] for trial in tried[:count] if trial[0] > tried[0][0] - NEAR]
        for (b, noise_index), group in groupby(sorted(near), lambda trial: trial[:2]):
            columns = [column for *_, column in group]
            yield float(self._trials[noise_index]), blocks[b].only(columns)


def likeliest_of(candidates: Iterable[Candidate]) -> Candidate:
    """Return the most probable candidate."""
    return max(candidates, key=lambda candidate: candidate.log_evidence)


def sound_recordings(scene: Scene, share: float = INDEPENDENT) -> Candidate:
    """Return the candidate by which nothing is wrong in a scene."""
    (candidate,) = Comparison(scene, ONLY_SOUND, share).candidates
    return candidate

"""Comparison of all explanations by Bayes' rule, and the scene once one was accepted."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, groupby, repeat
from itertools import count as count_from

import numpy as np

from ...results import Hypothesis
from .evidence import INDEPENDENT, LinearEvidence
from .kinds import Block, Kind, NoisePrior, Parameters
from .scene import Scene
from .table import KINDS, ONLY_SOUND

LARGEST = 0.3
"""Largest noise that is tried [m]."""
HALVES = 1.6
"""Factor from one trial of the noise to the next."""
STEP = 0.04
"""Step of the logarithm of the noise over which it is averaged."""
SPAN = 11
"""Steps each side of the best of the former trials."""
FACTORS = np.exp(STEP * np.arange(-SPAN, SPAN + 1))
TINY = 0.1
"""Largest joint position, below which another unit is likely [rad]: 4 rad, taken for degrees, are
0.07."""
REFINED = 3
"""Candidates of each kind whose evidence is refined."""
SEPARATE = 60
"""The same of a kind of which several candidates may be right."""
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
        (names,) = self.block.parameters
        numbers = {**names, "noise": self.sigma}
        if self.block.unknowns:
            values = self.evidence.posterior(self.block, self.sigma)[0]
            numbers |= self.kind.values(self.scene, numbers, values)
        return numbers

    def hypothesis(self, probability: float = 1.0) -> Hypothesis:
        """Return it in words."""
        kind = self.kind
        if self.of_points:
            kind = replace(kind, **kind.of_points)
        parameters = dict(self.parameters)
        advice = kind.advice.format(**parameters)
        largest = [np.abs(m.positions).max() for m in self.scene.measurements]
        if max(largest, default=0.0) < TINY:
            advice += (
                f"; or are the angles in another unit? none is beyond {TINY:g} rad"
            )
        return Hypothesis(
            kind.name,
            probability,
            parameters,
            kind.text(parameters),
            advice,
            kind.tell,
        )

    @property
    def of_points(self) -> bool:
        """True where it concerns points that an instrument measured, and no sockets."""
        (names,) = self.block.parameters
        placement = names.get("placement")
        measured = [m for m in self.scene.measurements if placement in (None, m.name)]
        return "frame" in names or all(m.kind == "points" for m in measured)

    @property
    def of_all(self) -> bool:
        """True where it concerns all placements, or the arm."""
        return "placement" not in self.parameters

    @property
    def has_no_effect(self) -> bool:
        """True where accepting it leaves the scene as it is, so that it would be found again."""
        changes_scene = self.kind.noise or self.kind.scene_after
        return not (changes_scene or self.block.columns.size)

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
        beside = self.block.columns[0, :, self.block.unknowns :]
        return beside.sum(axis=1)

    def as_cause(
        self,
        kind: Kind,
        parameters: Parameters,
        count: int,
        placement: str | None = None,
    ) -> "Candidate":
        """Return one of so many causes of a kind, by the scene that it changed, sound with it.

        ``placement`` is the name of the one that has it; None for all, or one in ``parameters``.
        """
        if placement is not None:
            parameters = {**parameters, "placement": placement}
        log_prior = math.log(kind.prior / count)
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
        columns = block.columns[0, :, : block.unknowns]
        columns = columns * max(block.widths)
        explained = (*scene.explained, (block.rows, columns, self.shift))
        return replace(scene, explained=explained).recentred(self.sigma)


def _as_it_is(scene: Scene, _: object) -> Scene:
    return scene


class Comparison:
    """The best candidates of each kind of explanation; a share of the errors counts."""

    def __init__(
        self,
        scene: Scene,
        kinds: Sequence[Kind] = KINDS,
        share: float = INDEPENDENT,
    ) -> None:
        self.scene = scene
        self.evidence = LinearEvidence(
            scene.residuals,
            scene.nuisances,
            share,
            scene.whitening,
        )
        smallest = max(scene.noise / 4, 1e-6)
        count = int(math.log(LARGEST / smallest, HALVES)) + 2
        self._trials = self.evidence.trials(smallest, LARGEST, count)
        possible = [kind for kind in kinds if not (kind.rigid and scene.zeros)]
        self.candidates = [*chain.from_iterable(map(self._of, possible))]

    def _of(self, kind: Kind) -> Iterator[Candidate]:
        """Yield the best candidates of a kind: by few trials of the noise, then by many."""
        scene = self.scene
        blocks = list(kind.blocks(scene))
        share = kind.prior / max(sum(len(block.parameters) for block in blocks), 1)
        prior = math.log(STEP * share)
        if kind.noise is None:
            # the noise of servos is never much less
            noise = NoisePrior(
                1.5 * scene.noise, scene.noise_width, below=not scene.zeros
            )
        else:
            noise = kind.noise(scene)
        count = SEPARATE if kind.separate else REFINED
        for trial, block in self._likeliest(blocks, noise, count):
            sigma = trial * FACTORS
            base = self.evidence.log_likelihood(sigma) + noise.log_density(sigma)
            over_widths = np.logaddexp.reduce(
                self.evidence.log_ratios(block, sigma), axis=1
            )
            logs = over_widths + base[:, None]
            evidence = np.logaddexp.reduce(logs, axis=0) + prior
            best = sigma[np.argmax(logs, axis=0)]
            pairs = zip(evidence.tolist(), best.tolist(), strict=True)
            for c, (log_evidence, likeliest) in enumerate(pairs):
                yield Candidate(
                    kind,
                    block.only([c]),
                    log_evidence,
                    likeliest,
                    scene,
                    self.evidence,
                )

    def _likeliest(
        self,
        blocks: Sequence[Block],
        noise: NoisePrior,
        count: int,
    ) -> Iterator[tuple[float, Block]]:
        """Yield the best columns of each block by few trials, and the noise at which they are."""
        sigma, base = self._trials
        prior = base + noise.log_density(sigma)
        # evidence, block, the noise at which it is most probable, and column in its block
        tried: list[tuple[float, int, int, int]] = []
        for b, block in enumerate(blocks):
            ratios = self.evidence.log_ratios(block, sigma)
            logs = ratios.max(axis=1) + prior[:, None]
            best = np.argmax(logs, axis=0).tolist()
            tried += zip(logs.max(axis=0).tolist(), repeat(b), best, count_from(0))
        tried.sort(reverse=True)
        near = [trial for log, *trial in tried[:count] if log > tried[0][0] - NEAR]
        for (b, noise_index), group in groupby(sorted(near), lambda trial: trial[:2]):
            columns = [column for *_, column in group]
            yield float(sigma[noise_index]), blocks[b].only(columns)


def likeliest_of(candidates: Iterable[Candidate]) -> Candidate:
    """Return the most probable candidate."""
    return max(candidates, key=lambda candidate: candidate.log_evidence)


def sound_recordings(
    scene: Scene,
    share: float = INDEPENDENT,
) -> Candidate:
    """Return the candidate by which nothing is wrong in a scene."""
    (candidate,) = Comparison(scene, ONLY_SOUND, share).candidates
    return candidate

"""A fault of a recording session, and the comparison with sound samples that names it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...recorder import Placement
from ..results import Hypothesis
from .hypotheses import Candidate, Parameters, Scene

RIVAL = 3.0
"""Log Bayes factor up to which a fault of another kind counts as nearly as probable."""


@dataclass(frozen=True)
class Fault:
    """A fault of a session, with the samples that it concerns."""

    hypothesis: Hypothesis
    placement: int
    samples: tuple[int, ...]
    """Numbers of the samples that are affected, as they were recorded."""
    evidence: float
    """Logarithm of its probability beside that of sound samples."""
    socket: int | None = None
    """Socket in which the ball truly was, where it was in another."""
    rivals: tuple["Fault", ...] = ()
    """Other kinds of fault that are nearly as probable, the most probable first."""


@dataclass(frozen=True)
class FaultComparison:
    """Explanations of some samples, compared with the hypothesis of sound ones."""

    sound: Candidate
    causes: Sequence[Candidate]
    evidence: float
    """Log Bayes factor of all causes together, over all arms that may be."""

    def beside(self, causes: Sequence[Candidate]) -> "FaultComparison":
        """Return the comparison with further causes of the same arm."""
        factors = [self.factor(candidate) for candidate in causes]
        evidence = np.logaddexp.reduce([self.evidence, *factors])
        return replace(self, causes=[*self.causes, *causes], evidence=float(evidence))

    @cached_property
    def best(self) -> Candidate:
        """The most probable cause."""
        return max(self.causes, key=self.factor)

    def factor(self, candidate: Candidate) -> float:
        """Return the log Bayes factor of a candidate against sound samples."""
        return candidate.log_evidence - self.sound.log_evidence

    @property
    def fault(self) -> Fault:
        """The most probable cause as a fault, with its rivals."""
        return replace(fault_of(self.best, self.factor(self.best)), rivals=self.rivals)

    @property
    def rivals(self) -> tuple[Fault, ...]:
        """The best of each other kind that is nearly as probable, the most probable first."""
        rivals = dict[str, Fault]()
        best = self.factor(self.best)
        for candidate in sorted(self.causes, key=self.factor, reverse=True):
            name = candidate.kind.name
            factor = self.factor(candidate)
            if best - factor < RIVAL and name not in (self.best.kind.name, *rivals):
                rivals[name] = fault_of(candidate, factor)
        return tuple(rivals.values())


def fault_of(candidate: Candidate, evidence: float) -> Fault:
    """Return a candidate as a fault, with the samples from its first one on."""
    scene, p = candidate.scene, candidate.parameters
    names = [m.name for m in scene.measurements]
    place = names.index(p.get("placement", names[-1]))
    placement = scene.measurements[place].placement
    numbers = p.get("numbers")
    if not numbers:
        first, end = _first_row(scene, place, p), len(placement.samples)
        if candidate.kind.name == "ball_sample":
            end = first + 1
        numbers = tuple(number_of(placement, row) for row in range(first, end))
    hypothesis = candidate.hypothesis()
    if "offset" in p and "size" not in p:
        sized = {**hypothesis.parameters, "size": _moved(scene, place, p)}
        hypothesis = replace(hypothesis, parameters=sized)
    return Fault(hypothesis, place, numbers, evidence, p.get("other"))


def _first_row(scene: Scene, place: int, p: Parameters) -> int:
    """Return the first sample that an explanation concerns, by its rank in the recording."""
    if "sample" not in p:
        return 0
    rows = scene.places[place]
    seat = scene.labels.index((p["placement"], p["socket"]))
    is_first = (scene.sockets[rows] == seat) & (scene.numbers[rows] == p["sample"])
    return int(scene.times[place][np.argmax(is_first)])


def _moved(scene: Scene, place: int, p: Parameters) -> float:
    """Return how far the ball moved by the offset of a joint, on average [m]."""
    joint = scene.robot.joint_names.index(p["joint"])
    slopes = scene.by_joints[scene.places[place], :, joint]
    levers = np.linalg.norm(slopes, axis=1)
    return abs(p["offset"]) * float(levers.mean())


def number_of(placement: Placement, row: int) -> int:
    """Return a sample's number as it was recorded, or its place from 1 on."""
    return placement.samples[row].number or row + 1

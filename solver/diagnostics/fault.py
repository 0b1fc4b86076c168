"""A cause as a fault of a recording session: its samples, and its rivals."""

from dataclasses import dataclass, replace

import numpy as np

from ...recorder import Placement
from ..results import Hypothesis
from .hypotheses import Candidate, Parameters, Scene
from .ranking import Ranking

EVIDENCE = 2.5
"""Log Bayes factor of all faults against sound samples from which the first is told."""
SHARE = 1.0
"""Share of the errors that counts as independent: with less, few samples take a fault for noise."""
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


def first_fault(ranking: Ranking, cause: Candidate) -> Fault:
    """Return a cause as a fault, with the best of each other kind that is nearly as probable."""
    factor = ranking.factor(cause)
    rivals = dict[str, Fault]()
    for rival in sorted(ranking.candidates[1:], key=ranking.factor, reverse=True):
        name, evidence = rival.kind.name, ranking.factor(rival)
        if factor - evidence < RIVAL and name not in (cause.kind.name, *rivals):
            rivals[name] = fault_of(rival, evidence)
    return replace(fault_of(cause, factor), rivals=tuple(rivals.values()))


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
        elif candidate.kind.name == "base_tipped":
            end = first + p["samples"]
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
    return int(scene.ranks[place][np.argmax(is_first)])


def _moved(scene: Scene, place: int, p: Parameters) -> float:
    """Return how far the ball moved by the offset of a joint, on average [m]."""
    joint = scene.robot.joint_names.index(p["joint"])
    slopes = scene.by_joints[scene.places[place], :, joint]
    levers = np.linalg.norm(slopes, axis=1)
    return abs(p["offset"]) * float(levers.mean())


def number_of(placement: Placement, row: int) -> int:
    """Return a sample's number as it was recorded, or its place from 1 on."""
    return placement.samples[row].number or row + 1

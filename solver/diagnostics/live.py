"""Faults of a recording session while it goes on, compared with the hypothesis of sound samples.

How often sound sessions may be called faulty sets the threshold (``benchmarks/sessions.py``).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, compress, pairwise

import numpy as np

from ...recorder import Placement
from ..data import CALIPER_DEVIATION, Measurement
from ..results import Hypothesis
from ..robot import Robot
from .configurations import known_distances
from .explain import scene_of
from .hypotheses import COARSE, CURABLE, ONLY_SOUND, Candidate, Comparison, Scene
from .robust_fit import ABOUT, FEW, RigidModel
from .samples import Samples

LEAST = 6
"""Fewest samples for a check."""
EVIDENCE, MORE = 2.5, 8.0
"""Log Bayes factor of all faults together against sound samples from which the first is reported,
and a further one."""
FORGOTTEN = 0.06
"""Prior probability of samples with a wrong socket number."""
DOUBT = -2.0
"""Log Bayes factor of any fault from which samples in other sockets are considered."""
STEPS, TIMES, CLOSE, LITTLE = 6, 2.0, 16, 1e-3
"""Steps of a fit to samples in other sockets; those that leave up to so many times the least error,
so many of them at most, and all that leave at most this [m], are looked at closely."""
MANY = 1000
"""More sockets than a base has."""
SHARE = 1.0
"""Share of the errors that counts as independent: with less, few samples take a fault for noise."""
PLAYS = tuple(np.deg2rad([0.05, 0.15, 0.45]).tolist())
"""Halves of the play that arms of servos may have [rad]."""
WIDES = (1.0, 3.0)
"""Factors on the effects of an arm; those of heavy arms are larger."""
NOT_OF_SERVOS = ("distance", "ball_loose")
"""Explanations that are not considered for arms made of servos."""
SMALL, CLEAN = 0.015, 2.0
"""Size [m] and remaining noise, as a multiple of the usual, of a fault that is no other socket."""
FAULTS = 3
"""Largest number of faults."""
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
    rivals: tuple[Hypothesis, ...] = ()
    """Other kinds of fault that are nearly as probable, the most probable first."""


def is_coarse(repeatability: float | None) -> bool:
    """Return True where joints may have play, for want of a known, good repeatability [m]."""
    return repeatability is None or repeatability > COARSE


class LiveCheck:
    """Check of a nominal robot's samples so far, by its repeatability [m], None if unknown."""

    def __init__(self, robot: Robot, repeatability: float | None) -> None:
        zeros = is_coarse(repeatability)
        # a fit with zeros that are off by degrees may be off in size, and in noise
        self._kinds = [k for k in CURABLE if not zeros or k.name not in NOT_OF_SERVOS]
        self._model = RigidModel(robot, zeros=zeros)
        self._repeatability = repeatability

    def faults(self, placements: Sequence[Placement]) -> tuple[Fault, ...]:
        """Return the faults of placements, the last one still going on, the most probable first.

        Their joints are in the robot's order, and their distances are there where they are known.
        """
        faults: list[Fault] = []
        if not placements[-1].samples or sum(len(p.samples) for p in placements) < LEAST:
            return ()
        scene, current = self.scene(placements), placements
        while len(faults) < FAULTS:
            (first, *rivals), evidence = self._compared(scene)
            scene, sound = first.scene, first.log_evidence
            logs = [c.log_evidence - sound for c in rivals]
            if evidence < DOUBT:
                break
            likeliest = max(rivals, key=lambda c: c.log_evidence)
            # where one small fault leaves nothing more, no samples lie in another socket; nor are
            # they looked for beside another fault, which only both together would explain
            clean = likeliest.sigma < CLEAN * scene.noise
            clean = clean and likeliest.parameters.get("size", math.inf) < SMALL
            throughout = clean and likeliest.log_evidence - sound > EVIDENCE
            elsewhere = (
                [] if throughout or scene.explained else list(self._elsewhere(current, scene))
            )
            logs += [log - sound for log, _, _ in elsewhere]
            total = np.logaddexp.reduce([evidence, *logs[len(rivals) :]])
            if total < (MORE if faults else EVIDENCE):
                break
            best = int(np.argmax(logs))
            if best >= len(rivals):
                _, current, fault = elsewhere[best - len(rivals)]
                faults.append(replace(fault, evidence=logs[best]))
                scene = self.scene(current)
            else:
                fault = _fault(rivals[best], logs[best])
                is_loose = rivals[best].kind.noise is not None
                balls = self._unseated(rivals, sound, logs[best]) if is_loose else []
                faults += balls or [replace(fault, rivals=_rivals(rivals, logs, best))]
                if is_loose:
                    break
                scene = rivals[best].after()
        return tuple(faults)

    def _unseated(
        self, rivals: Sequence[Candidate], sound: float, evidence_loose: float
    ) -> list[Fault]:
        """Return balls that were not seated, if a few explain the scatter better; else none."""
        faults, evidence = list[Fault](), 0.0
        for _ in range(FAULTS):
            balls = [c for c in rivals if c.kind.name == "ball_sample"]
            best = max(balls, key=lambda c: c.log_evidence, default=None)
            if best is None or best.log_evidence - sound < 0:
                break
            evidence += best.log_evidence - sound
            faults.append(_fault(best, best.log_evidence - sound))
            if evidence > evidence_loose:
                return faults
            (first, *rivals), _ = self._compared(best.after())
            sound = first.log_evidence
        return []

    def scene(self, placements: Sequence[Placement], start: np.ndarray | None = None) -> Scene:
        """Return the samples as a linear model about a robust fit, begun at some unknowns."""
        measured = [Measurement(p, p.distance or 0.0) for p in placements]
        lengths = [k for k in known_distances(measured, (), CALIPER_DEVIATION) if k.distance]
        nothing = [0.0] * len(measured)
        return scene_of(self._model, measured, lengths, self._repeatability, nothing, start)

    def _compared(self, scene: Scene) -> tuple[list[Candidate], float]:
        """Return explanations by the most probable arm, and the log Bayes factor over all arms."""
        arms = [replace(scene, play=p, wide=max(WIDES)) for p in PLAYS if scene.zeros]
        arms = arms or [replace(scene, wide=wide) for wide in WIDES]
        comparisons = [Comparison(arm, self._kinds, SHARE).candidates for arm in arms]
        # sound is compared first
        sound = [candidates[0].log_evidence for candidates in comparisons]
        fault = list[float]()
        for _, *faults in comparisons:
            fault.append(float(np.logaddexp.reduce([c.log_evidence for c in faults])))
        evidence = np.logaddexp.reduce(fault) - np.logaddexp.reduce(sound)
        return comparisons[int(np.argmax(np.logaddexp(fault, sound)))], float(evidence)

    def _elsewhere(
        self, placements: Sequence[Placement], arm: Scene
    ) -> Iterator[tuple[float, Sequence[Placement], Fault]]:
        """Yield evidence, corrected placements and fault of samples in another socket."""
        *before, placement = placements
        runs = list(_runs(placement))
        prior = math.log(FORGOTTEN / max(len(runs), 1))
        errors = self._left(placements, arm.x, runs)
        limit = min([TIMES * min(errors, default=0.0), *sorted(errors)[CLOSE : CLOSE + 1]])
        for rows, socket in compress(runs, [error <= max(LITTLE, limit) for error in errors]):
            samples = tuple(
                replace(s, socket=socket) if i in rows else s
                for i, s in enumerate(placement.samples)
            )
            relabelled = [*before, replace(placement, samples=samples)]
            scene = replace(self.scene(relabelled, arm.x), play=arm.play, wide=arm.wide)
            sound = Comparison(scene, ONLY_SOUND, SHARE).candidates[0]
            log = sound.log_evidence + prior
            yield log, relabelled, _forgotten(placement, len(before), rows, socket, sound.sigma)

    def _left(
        self, placements: Sequence[Placement], x: np.ndarray, runs: Sequence[tuple[range, int]]
    ) -> list[float]:
        """Return the mean error of a linear fit with each of some runs corrected [m]."""
        count = max(ABOUT // (len(placements) or 1), FEW)
        few = [p.samples[:: max(len(p.samples) // count, 1)] for p in placements[:-1]]
        parts = [*few, placements[-1].samples]
        q = np.array([s.position for s in chain(*parts)])
        of_parts = np.repeat(np.arange(len(parts)), [*map(len, parts)])
        labels_recorded = np.column_stack([of_parts, [s.socket for s in chain(*parts)]])
        linear, errors = self._model.linearised(x, q), list[float]()
        for rows, socket in runs:
            labels = labels_recorded.copy()
            labels[len(labels_recorded) - len(parts[-1]) + np.array(rows), 1] = socket
            sockets = np.unique(labels @ [MANY, 1], return_inverse=True)[1]
            fit = self._model.fit(Samples(q, sockets), STEPS, x, linear)
            errors.append(float(fit.errors.mean()))
        return errors


def _runs(placement: Placement) -> Iterator[tuple[range, int]]:
    """Yield samples at a change of socket that may be numbered wrongly, and their true socket."""
    sockets = [sample.socket for sample in placement.samples]
    changes = [i for i in range(1, len(sockets)) if sockets[i] != sockets[i - 1]]
    for first, end in pairwise([0, *changes, len(sockets)]):
        before = sockets[first - 1] if first else sockets[0] + 1
        for last in range(first + 1, end + 1) if first else ():
            yield range(first, last), before
        for begin in range(end - 1, first, -1):
            yield range(begin, end), sockets[end] if end < len(sockets) else before


def _forgotten(placement: Placement, index: int, rows: range, socket: int, noise: float) -> Fault:
    numbers = tuple(_number(placement, i) for i in rows)
    label = placement.samples[rows[0]].socket
    many = f"samples {numbers[0]} to {numbers[-1]} lie"
    which = many if numbers[-1] != numbers[0] else f"sample {numbers[0]} lies"
    text = f"{which} in socket {socket}, not {label}"
    hypothesis = Hypothesis(
        "socket",
        1.0,
        {"placement": placement.name, "sample": rows[0], "socket": label, "noise": noise},
        text,
        "was a change of socket forgotten?",
        "",
    )
    return Fault(hypothesis, index, numbers, 0.0, socket)


def _number(placement: Placement, row: int) -> int:
    return placement.samples[row].number or row + 1


def _rivals(
    candidates: Sequence[Candidate], logs: Sequence[float], best: int
) -> tuple[Hypothesis, ...]:
    """Return the best of each other kind that is nearly as probable, the most probable first."""
    rivals: dict[str, Hypothesis] = {}
    order: list[int] = np.argsort(logs[: len(candidates)])[::-1].tolist()
    for i in order:
        candidate = candidates[i]
        is_near = logs[best] - logs[i] < RIVAL
        if is_near and candidate.kind.name not in (candidates[best].kind.name, *rivals):
            rivals[candidate.kind.name] = _fault(candidate, logs[i]).hypothesis
    return tuple(rivals.values())


def _fault(candidate: Candidate, evidence: float) -> Fault:
    scene, p = candidate.scene, candidate.parameters
    names = [m.name for m in scene.measurements]
    place = names.index(p["placement"]) if "placement" in p else len(names) - 1
    placement, rows = scene.measurements[place].placement, scene.places[place]
    first, last = 0, len(placement.samples)
    if "sample" in p:
        in_socket = scene.sockets[rows] == scene.labels.index((names[place], p["socket"]))
        first = int(scene.times[place][np.argmax(in_socket & (scene.numbers[rows] == p["sample"]))])
    if candidate.kind.name == "ball_sample":
        last = first + 1
    numbers = tuple(_number(placement, i) for i in range(first, last))
    hypothesis = candidate.hypothesis()
    if "offset" in p and "size" not in p:  # of a joint, how far its ball moved
        joint = scene.robot.joint_names.index(p["joint"])
        arms = np.linalg.norm(scene.by_joints[rows, :, joint], axis=1)
        size = abs(p["offset"]) * float(arms.mean())
        hypothesis = replace(hypothesis, parameters={**hypothesis.parameters, "size": size})
    return Fault(hypothesis, place, numbers, evidence)

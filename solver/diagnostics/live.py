"""Faults of a recording session while it goes on, compared with the hypothesis of sound samples.

How often sound sessions may be called faulty sets the threshold (``benchmarks/sessions.py``).
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from ...recorder import Placement
from ..data import Measurement, RobotRecordings, places_of
from ..robot import Robot
from .explain import scene_of
from .fault import Fault, FaultComparison, fault_of
from .hypotheses import (
    COARSE,
    CURABLE,
    Candidate,
    Comparison,
    Samples,
    Scene,
    sound_recordings,
)
from .relabelling import FORGOTTEN, Run, forgotten, relabelled, runs_of
from .robust_fit import ABOUT, FEW, RigidModel

LEAST = 6
"""Fewest samples for a check."""
EVIDENCE, MORE = 2.5, 8.0
"""Log Bayes factor of all faults together against sound samples from which the first is reported,
and a further one."""
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
        count = sum(len(placement.samples) for placement in placements)
        if not placements[-1].samples or count < LEAST:
            return ()
        faults = list[Fault]()
        scene, current = self.scene(placements), placements
        while len(faults) < FAULTS:
            comparison = self._compared(scene)
            if comparison.evidence > DOUBT:
                comparison = comparison.beside(self._relabelled(current, comparison))
            if comparison.evidence < (MORE if faults else EVIDENCE):
                break
            best = comparison.best
            if best.kind.noise is not None:
                return (*faults, *(self._unseated(comparison) or [comparison.fault]))
            faults.append(comparison.fault)
            scene = best.after()
            if best.kind.name == FORGOTTEN.name:
                run = Run(best.parameters["rows"], best.parameters["other"])
                current = [*current[:-1], relabelled(current[-1], run)]
        return tuple(faults)

    def _unseated(self, comparison: FaultComparison) -> list[Fault]:
        """Return balls that were not seated, if a few explain the scatter better; else none."""
        faults, evidence = list[Fault](), 0.0
        evidence_loose = comparison.factor(comparison.best)
        for _ in range(FAULTS):
            balls = [c for c in comparison.causes if c.kind.name == "ball_sample"]
            best = max(balls, key=comparison.factor, default=comparison.sound)
            factor = comparison.factor(best)
            if best is comparison.sound or factor < 0:
                break
            evidence += factor
            faults.append(fault_of(best, factor))
            if evidence > evidence_loose:
                return faults
            comparison = self._compared(best.after())
        return []

    def scene(
        self, placements: Sequence[Placement], start: np.ndarray | None = None
    ) -> Scene:
        """Return the samples as a linear model about a robust fit, begun at some unknowns."""
        measured = [Measurement(p, p.distance or 0.0) for p in placements]
        places = places_of(
            [RobotRecordings(self._model.robot, measured)], require_scale=False
        )
        lengths = [length for length in places.known if length.distance]
        nothing = [0.0] * len(measured)
        return scene_of(
            self._model, measured, lengths, self._repeatability, nothing, start
        )

    def _compared(self, scene: Scene) -> FaultComparison:
        """Return explanations by the most probable arm, and their evidence over all arms."""
        if scene.zeros:
            arms = [replace(scene, play=play, wide=max(WIDES)) for play in PLAYS]
        else:
            arms = [replace(scene, wide=wide) for wide in WIDES]
        comparisons = [Comparison(arm, self._kinds, SHARE).candidates for arm in arms]
        logs = [[c.log_evidence for c in candidates] for candidates in comparisons]
        evidence_of_arms = [np.logaddexp.reduce(logs_of_arm) for logs_of_arm in logs]
        of_sound = np.logaddexp.reduce([sound for sound, *_ in logs])
        of_causes = np.logaddexp.reduce(
            [*chain.from_iterable(causes for _, *causes in logs)]
        )
        first, *others = comparisons[int(np.argmax(evidence_of_arms))]
        return FaultComparison(first, others, float(of_causes - of_sound))

    def _relabelled(
        self, placements: Sequence[Placement], comparison: FaultComparison
    ) -> list[Candidate]:
        """Return samples that may be of another socket, as causes.

        None are looked for where one small fault leaves nothing more, nor beside another fault,
        which only both together would explain.
        """
        arm, best = comparison.sound.scene, comparison.best
        is_small = best.parameters.get("size", math.inf) < SMALL
        leaves_nothing = best.sigma < CLEAN * arm.noise
        if arm.explained or (
            is_small and leaves_nothing and comparison.factor(best) > EVIDENCE
        ):
            return []
        *before, placement = placements
        runs = list(runs_of(placement))
        prior = math.log(FORGOTTEN.prior / max(len(runs), 1))
        errors = self._left(placements, arm.x, runs)
        limit = min(
            [TIMES * min(errors, default=0.0), *sorted(errors)[CLOSE : CLOSE + 1]]
        )
        causes = list[Candidate]()
        for run, error in zip(runs, errors, strict=True):
            if error <= max(LITTLE, limit):
                parts = [*before, relabelled(placement, run)]
                scene = replace(self.scene(parts, arm.x), play=arm.play, wide=arm.wide)
                sound = sound_recordings(scene, SHARE)
                causes.append(forgotten(sound, placement, run, prior))
        return causes

    def _left(
        self, placements: Sequence[Placement], x: np.ndarray, runs: Sequence[Run]
    ) -> list[float]:
        """Return the mean error of a linear fit with each of some runs corrected [m]."""
        count = max(ABOUT // len(placements), FEW)
        few = [p.samples[:: max(len(p.samples) // count, 1)] for p in placements[:-1]]
        parts = [*few, placements[-1].samples]
        last = len(few)
        q = np.array([s.position for s in chain(*parts)])
        seats = np.array(
            [MANY * i + s.socket for i, part in enumerate(parts) for s in part]
        )
        start = len(q) - len(parts[last])
        no_points = np.zeros((len(q), 3))
        linear = self._model.linearised(x, q)
        errors: list[float] = []
        for rows, socket in runs:
            of_run = seats.copy()
            of_run[start + np.array(rows)] = MANY * last + socket
            sockets = np.unique(of_run, return_inverse=True)[1]
            fit = self._model.fit(Samples(q, sockets, no_points), STEPS, x, linear)
            errors.append(float(fit.errors.mean()))
        return errors

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
from .scene_fit import scene_of

LEAST = 6
"""Fewest samples for a check."""
EVIDENCE = 2.5
"""Log Bayes factor of all faults against sound samples from which the first is reported."""
MORE = 8.0
"""The same for a further one."""
DOUBT = -2.0
"""Log Bayes factor of any fault from which samples in other sockets are considered."""
STEPS = 6
"""Steps of a fit to samples in other sockets."""
TIMES = 2.0
"""Those that leave up to so many times the least error are looked at closely."""
CLOSE = 16
"""So many of them are, at most."""
LITTLE = 1e-3
"""All that leave at most this are looked at closely [m]."""
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
SMALL = 0.015
"""Size of a fault that is no other socket [m]."""
CLEAN = 2.0
"""Noise that such a fault may leave, as a multiple of the usual."""
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
        faults: list[Fault] = []
        evidence = 0.0
        evidence_loose = comparison.factor(comparison.best)
        for _ in range(FAULTS):
            balls = [c for c in comparison.causes if c.kind.name == "ball_sample"]
            if not balls:
                break
            best = max(balls, key=comparison.factor)
            factor = comparison.factor(best)
            if factor < 0:
                break
            evidence += factor
            faults.append(fault_of(best, factor))
            if evidence > evidence_loose:
                return faults
            comparison = self._compared(best.after())
        return []

    def scene(
        self,
        placements: Sequence[Placement],
        start: np.ndarray | None = None,
    ) -> Scene:
        """Return the samples as a linear model about a robust fit, begun at some unknowns."""
        measured = [Measurement(p, p.distance or 0.0) for p in placements]
        recordings = RobotRecordings(self._model.robot, measured)
        places = places_of([recordings], require_scale=False)
        lengths = [length for length in places.known if length.distance]
        return scene_of(
            self._model,
            measured,
            lengths,
            self._repeatability,
            floors=[0.0] * len(measured),
            start=start,
        )

    def _compared(self, scene: Scene) -> FaultComparison:
        """Return explanations by the most probable arm, and their evidence over all arms."""
        if scene.zeros:
            arms = [replace(scene, play=play, wide=max(WIDES)) for play in PLAYS]
        else:
            arms = [replace(scene, wide=wide) for wide in WIDES]
        comparisons: list[FaultComparison] = []
        of_arms: list[float] = []
        of_sound: list[float] = []
        of_causes: list[float] = []
        for arm in arms:
            candidates = Comparison(arm, self._kinds, SHARE).candidates
            logs = [candidate.log_evidence for candidate in candidates]
            of_arms.append(float(np.logaddexp.reduce(logs)))
            of_sound.append(logs[0])
            of_causes += logs[1:]
            comparisons.append(FaultComparison(candidates[0], candidates[1:], 0.0))
        likeliest = comparisons[int(np.argmax(of_arms))]
        evidence = np.logaddexp.reduce(of_causes) - np.logaddexp.reduce(of_sound)
        return replace(likeliest, evidence=float(evidence))

    def _relabelled(
        self,
        placements: Sequence[Placement],
        comparison: FaultComparison,
    ) -> list[Candidate]:
        """Return samples that may be of another socket, as causes.

        None are looked for where one small fault leaves nothing more, nor beside another fault,
        which only both together would explain.
        """
        arm, best = comparison.sound.scene, comparison.best
        is_small = best.parameters.get("size", math.inf) < SMALL
        leaves_nothing = best.sigma < CLEAN * arm.noise
        is_told = comparison.factor(best) > EVIDENCE
        if arm.explained or (is_small and leaves_nothing and is_told):
            return []
        *before, placement = placements
        runs = list(runs_of(placement))
        prior = math.log(FORGOTTEN.prior / max(len(runs), 1))
        errors = self._left(placements, arm.x, runs)
        ascending = sorted(errors)
        limits = [TIMES * error for error in ascending[:1]]
        limits += ascending[CLOSE : CLOSE + 1]
        limit = min(limits, default=0.0)
        causes: list[Candidate] = []
        for run, error in zip(runs, errors, strict=True):
            if error <= max(LITTLE, limit):
                parts = [*before, relabelled(placement, run)]
                scene = self.scene(parts, arm.x)
                of_arm = replace(scene, play=arm.play, wide=arm.wide)
                sound = sound_recordings(of_arm, SHARE)
                causes.append(forgotten(sound, placement, run, prior))
        return causes

    def _left(
        self,
        placements: Sequence[Placement],
        x: np.ndarray,
        runs: Sequence[Run],
    ) -> list[float]:
        """Return the mean error of a linear fit with each of some runs corrected [m]."""
        *before, placement = placements
        count = max(ABOUT // len(placements), FEW)
        parts = [p.samples[:: max(len(p.samples) // count, 1)] for p in before]
        start = sum(map(len, parts))
        parts.append(placement.samples)
        last = MANY * len(before)
        q = np.array([sample.position for sample in chain(*parts)])
        seats_of_all: list[int] = []
        for i, part in enumerate(parts):
            seats_of_all += [MANY * i + sample.socket for sample in part]
        seats = np.array(seats_of_all)
        no_points = np.zeros((len(q), 3))
        linear = self._model.linearised(x, q)
        errors: list[float] = []
        for rows, socket in runs:
            of_run = seats.copy()
            of_run[start + np.array(rows)] = last + socket
            _, sockets = np.unique(of_run, return_inverse=True)
            samples = Samples(q, sockets, no_points)
            fit = self._model.fit(samples, STEPS, x, linear)
            errors.append(float(fit.errors.mean()))
        return errors

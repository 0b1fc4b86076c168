"""Faults of a recording session while it goes on, compared with the hypothesis of sound samples.

How often sound sessions may be called faulty sets the thresholds.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...recorder import Placement
from ..identification.data import Measurement
from ..identification.robot import Robot
from .explain import Acceptance, rounds
from .fault import EVIDENCE, SHARE, Fault, fault_of, first_fault, of_sockets
from .hypotheses import COARSE, CURABLE, Candidate, Comparison, Scene
from .ranking import Ranking, ranking_of
from .robust_fit import RigidModel
from .scene_fit import Given, scene_of

LEAST = 6
"""Fewest samples for a check."""
LIVE = Acceptance(EVIDENCE, further=8.0, rounds=3)
"""Thresholds of faults."""
SCATTER = replace(LIVE, first=0.0, further=0.0)
"""Thresholds of balls that were not seated, where all samples scatter."""
PLAYS = tuple(np.deg2rad([0.05, 0.15, 0.45]).tolist())
"""Halves of the play that arms of servos may have [rad]."""
WIDES = (1.0, 3.0)
"""Factors on the effects of an arm; those of heavy arms are larger."""
NOT_OF_SERVOS = ("distance", "ball_loose")
"""Explanations that are not considered for arms made of servos."""


def is_coarse(repeatability: float | None) -> bool:
    """Return True where joints may have play, for want of a known, good repeatability [m]."""
    return repeatability is None or repeatability > COARSE


class LiveCheck:
    """Check of a nominal robot's samples so far, by its repeatability [m], None if unknown."""

    def __init__(
        self,
        robot: Robot,
        repeatability: float | None,
    ) -> None:
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

        def rank(scene: Scene, before: Sequence[Candidate]) -> Ranking:
            ranking = self._of_arms(scene)
            causes = of_sockets(self._model, self.scene, placements, ranking, before)
            return ranking.beside([*causes])

        faults: list[Fault] = []
        for ranking, causes in rounds(self.scene(placements), rank, LIVE):
            for cause in causes:
                told = [first_fault(ranking, cause)]
                if cause.kind.noise is not None:
                    told = self._unseated(cause, told[0].evidence) or told
                    return (*faults, *told)
                faults += told
        return tuple(faults)

    def _of_arms(self, scene: Scene) -> Ranking:
        """Return explanations by all that an arm may be: joints with play, or links that bend."""
        if scene.zeros:
            arms = [replace(scene, play=play, wide=max(WIDES)) for play in PLAYS]
        else:
            arms = [replace(scene, wide=wide) for wide in WIDES]
        return ranking_of(Comparison(arm, self._kinds, SHARE) for arm in arms)

    def _unseated(
        self,
        loose: Candidate,
        evidence: float,
    ) -> list[Fault]:
        """Return balls that were not seated, if a few explain the scatter better; else none."""
        faults: list[Fault] = []
        for ranking, causes in rounds(loose.scene, self.of_balls, SCATTER):
            faults += [fault_of(ball, ranking.factor(ball)) for ball in causes]
            if sum(fault.evidence for fault in faults) > evidence:
                return faults
        return []

    def of_balls(
        self,
        scene: Scene,
        _: object,
    ) -> Ranking:
        """Return balls that were probably not seated, as the only causes."""
        ranking = self._of_arms(scene)
        balls = [
            c
            for c in ranking.candidates
            if c.kind.name == "ball_sample" and ranking.factor(c) > 0
        ]
        return Ranking([ranking.sound], -math.inf).beside(balls)

    def scene(
        self,
        placements: Sequence[Placement],
        start: np.ndarray | None = None,
    ) -> Scene:
        """Return the samples as a linear model about a robust fit, begun at some unknowns."""
        measured = [Measurement(p, p.distance or 0.0) for p in placements]
        no_floors = np.zeros(len(measured)).tolist()
        return scene_of(
            self._model, measured, Given(), self._repeatability, no_floors, start
        )

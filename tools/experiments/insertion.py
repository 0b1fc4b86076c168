"""The peg insertion of Section IV-B: a goal is taught once, and reached from other postures.

A calibrated base frame may lean, so the way out of the hole and the table's axes are taught too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .controller import Pose
from .motion import Cell, Trial, hold, move, shifted, stratified
from .results import Insertion, Insertions
from .scene import HOLE_DEPTH, TABLE

CENTRE = np.array([0.5, 0.0])
"""The taught hole on the table [m]."""
TAUGHT_DEPTH = 0.015
"""Depth of the peg in the hole when the goal was taught [m]."""
INSERTED_DEPTH = 0.005
"""A peg this far below the hole's rim is in it; nothing but the hole lets it below [m]."""
HOVER = 0.035
"""Height above the goal from which the peg goes straight down [m]."""
PLAY = 5e-5
"""Of the peg in the tight hole in which it is taught: 10 mm in 10.1 mm, to each side [m]."""
STEP = 0.025
PER_BRANCH = 6
BRANCHES = np.array([[1, 1], [-1, -1], [1, -1], [-1, 1]]) / 2**0.5
"""Directions of the X on the table; the second and fourth go on from the first and third."""


@dataclass(frozen=True)
class Taught:
    """The taught goal, by the model's forward kinematics."""

    goal: Pose
    """The peg's pose in the hole."""
    out: np.ndarray
    """Unit vector out of the hole, shape (3,)."""

    def moved(self, offset: np.ndarray) -> "Taught":
        """Return the same for a hole moved by an offset, shape (3,) [m]."""
        return Taught(shifted(self.goal, offset), self.out)

    @property
    def hover(self) -> Pose:
        """The pose above the hole from which the peg goes in."""
        return shifted(self.goal, HOVER * self.out)


def tip_at(hole: np.ndarray, height: float = 0.0) -> np.ndarray:
    """Return where a tip truly is that is at the taught depth in a hole, or above that [m]."""
    return np.array([*hole, TABLE + HOLE_DEPTH - TAUGHT_DEPTH + height])


def teach(cell: Cell, hole: np.ndarray, generator: np.random.Generator) -> Taught:
    """Guide the arm into a tight hole, and as far out as the hole still guides the peg."""
    goal = cell.model.pose(_guide(cell, tip_at(hole), generator))
    mouth = cell.model.pose(_guide(cell, tip_at(hole, TAUGHT_DEPTH), generator))
    out = mouth.translation - goal.translation
    return Taught(goal, out / np.linalg.norm(out))


def _guide(cell: Cell, point: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return where the arm is guided to; the peg lies in the tight hole with a little play."""
    radius, angle = PLAY * generator.uniform() ** 0.5, generator.uniform(-np.pi, np.pi)
    aside = np.array([radius * np.cos(angle), radius * np.sin(angle), 0.0])
    return cell.guide(point + aside)


def insert_at_centre(cell: Cell, count: int, seed: int) -> Iterator[Trial[Insertion]]:
    """Insert into the hole that was taught, from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 0])
    taught = teach(cell, CENTRE, generator)
    for fraction in stratified(count, generator):
        yield insert(cell, CENTRE, taught, float(fraction), generator)


def insert_on_cross(cell: Cell, count: int, seed: int) -> Iterator[Trial[Insertion]]:
    """Insert at the first positions of the X; taught are its centre and two branches' ends."""
    generator = np.random.default_rng([seed, 1])
    taught = teach(cell, CENTRE, generator)
    axes: list[np.ndarray] = []
    for branch in BRANCHES[::2]:
        end = teach(cell, CENTRE + PER_BRANCH * STEP * branch, generator)
        axis = end.goal.translation - taught.goal.translation
        axes += [axis / np.linalg.norm(axis), -axis / np.linalg.norm(axis)]
    for place, fraction in enumerate(stratified(count, generator)):
        branch, step = place % len(BRANCHES), 1 + place // len(BRANCHES)
        hole = CENTRE + step * STEP * BRANCHES[branch]
        goal = taught.moved(step * STEP * axes[branch])
        yield insert(cell, hole, goal, float(fraction), generator)


def insert(
    cell: Cell, hole: np.ndarray, taught: Taught, fraction: float, generator: np.random.Generator
) -> Trial[Insertion]:
    """Put the peg into a hole, shape (2,) [m], from 0 to 1 of the elbow's range."""
    start = cell.start(tip_at(hole, HOVER), fraction, generator)
    cell.scene.place_hole(hole)
    down = move("insert", 4.0, taught.hover, taught.goal)
    then = [down, hold("rest", 1.0, taught.goal)]
    log, done = cell.perform(start, taught.hover, then, ("insert", "rest"))
    depth = float(TABLE + HOLE_DEPTH - log.tip[-1, 2])
    x, y, z = (log.tip[log.during("compensate")[-1]] - tip_at(hole, HOVER)).tolist()
    inserted, at = depth > INSERTED_DEPTH, tuple(hole.tolist())
    return Trial(log, Insertion(**done, hole=at, inserted=inserted, depth=depth, miss=(x, y, z)))


def insertion_results(trials: Sequence[Trial[Insertion]]) -> Insertions:
    """Return counts, tracking errors and forces of some insertions, and each by itself."""
    each = tuple(trial.result for trial in trials)
    return Insertions(
        inserted=sum(one.inserted for one in each),
        trials=len(each),
        each=each,
        **Insertions.fields_of(each, [float(np.linalg.norm(one.miss)) for one in each]),
    )

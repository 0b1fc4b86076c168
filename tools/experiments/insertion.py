"""The peg insertion experiment of Section IV-B.

The goal is taught once, elbow up, in a tight hole, by the model's own forward kinematics; then the
peg is inserted from other postures. A calibrated model's base frame is free to lean by a degree or
two, since nothing outside the arm was measured: so the way out of the hole and the axes of the
table are taught as well, and none is taken from the model's axes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .cell import TABLE, Cell
from .controller import TABLE_II, Pose
from .motion import Log, hold, move
from .postures import stratified
from .results import Insertion, Insertions
from .scene import HOLE_DEPTH

CENTRE = np.array([0.5, 0.0])
"""The taught hole on the table [m]."""
TAUGHT_DEPTH = 0.015
"""Depth of the peg in the hole when the goal was taught [m]."""
INSERTED_DEPTH = 0.005
"""A peg whose tip came this far below the hole's rim is in it [m]."""
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
        goal = self.goal.copy()
        goal.translation = goal.translation + offset
        return Taught(goal, self.out)

    @property
    def hover(self) -> Pose:
        """The pose above the hole from which the peg goes in."""
        return self.moved(HOVER * self.out).goal


@dataclass(frozen=True)
class Trial:
    """One insertion."""

    log: Log
    hole: np.ndarray
    """True position of the hole's axis on the table, shape (2,) [m]."""
    elbow: float
    """The elbow's angle at the start [rad]."""

    @property
    def depth(self) -> float:
        """Final depth of the tip below the hole's rim, negative above it [m]."""
        return float(TABLE + HOLE_DEPTH - self.log.tip[-1, 2])

    @property
    def inserted(self) -> bool:
        """True if the peg was in the hole in the end; nothing but the hole lets it below."""
        return self.depth > INSERTED_DEPTH

    @property
    def tracking_error(self) -> float:
        """True distance of the tip from its place above the hole, before it went down [m]."""
        return float(np.linalg.norm(self.miss))

    @property
    def miss(self) -> np.ndarray:
        """Offset of the tip just before it went down from where it should be, shape (3,) [m]."""
        return self.log.tip[self.log.during("compensate")[-1]] - tip_at(self.hole, HOVER)

    @property
    def forces(self) -> np.ndarray:
        """Magnitude of the contact force from the way down to the end, shape (N,) [N]."""
        return np.linalg.norm(self.log.force[self.log.during("insert", "rest")], axis=1)


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


def insert_at_centre(cell: Cell, count: int, seed: int) -> Iterator[Trial]:
    """Insert into the hole that was taught, from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 0])
    taught = teach(cell, CENTRE, generator)
    for fraction in stratified(count, generator):
        yield insert(cell, CENTRE, taught, float(fraction), generator)


def insert_on_cross(cell: Cell, count: int, seed: int) -> Iterator[Trial]:
    """Insert at the first positions of the X, 6 on each of 4 branches, 25 mm apart.

    Taught are the centre and the ends of two branches; all goals follow from these.
    """
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
) -> Trial:
    """Go above the hole, let the compensator remove the offset, and put the peg in without it.

    Args:
        cell: The arm and its surroundings.
        hole: True position of the hole's axis on the table, shape (2,) [m].
        taught: The goal by the model.
        fraction: Start in the elbow's range, 0 to 1.
        generator: Source of randomness.
    """
    start = cell.start(tip_at(hole, HOVER), fraction, generator)
    cell.scene.place_hole(hole)
    log = cell.perform(
        start,
        [
            move("approach", 3.0, cell.model.pose(start), taught.hover),
            hold("compensate", TABLE_II.window, taught.hover, compensate=True),
            move("insert", 4.0, taught.hover, taught.goal),
            hold("rest", 1.0, taught.goal),
        ],
    )
    return Trial(log, hole, cell.elbow(start))


def insertion_results(trials: Sequence[Trial]) -> Insertions:
    """Return counts, tracking errors and forces of some insertions, and each by itself."""
    return Insertions(
        inserted=sum(trial.inserted for trial in trials),
        trials=len(trials),
        each=tuple(map(_insertion, trials)),
        **Insertions.fields_of(trials),
    )


def _insertion(trial: Trial) -> Insertion:
    x, y, z = trial.miss.tolist()
    return Insertion(
        hole=tuple(trial.hole.tolist()),
        elbow=trial.elbow,
        inserted=trial.inserted,
        depth=trial.depth,
        miss=(x, y, z),
        force=float(trial.forces.mean()),
        peak_force=float(trial.forces.max()),
    )

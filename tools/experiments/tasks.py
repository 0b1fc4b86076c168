"""The tasks of Section IV-B: to insert a peg, and to retrace a drawing, as taught in one posture.

A calibrated base frame may lean, so the way out of the hole and the axes of the table are taught
too; the drawing is shown, elbow up.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from ..simulation import horizontal
from .controller import Pose
from .motion import (
    Cell,
    Log,
    Phase,
    Trial,
    hold,
    move,
    pose_above,
    reach,
    shifted,
    smooth,
    stratified,
    unit,
)
from .results import Drawing, Insertion, Insertions, Motion, Retracing, Trials
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


def tip_at(hole: np.ndarray, height: float = 0.0) -> np.ndarray:
    """Return where a tip truly is that is at the taught depth in a hole, or above that [m]."""
    taught_height = TABLE + HOLE_DEPTH - TAUGHT_DEPTH
    return np.array([*hole, taught_height + height])


def teach(
    cell: Cell, hole: np.ndarray, generator: np.random.Generator
) -> tuple[Pose, np.ndarray]:
    """Guide the arm into a tight hole, and as far out as the hole still guides the peg.

    Returns, by the model's forward kinematics, the peg's pose in the hole, and the unit vector out
    of the hole, shape (3,).
    """
    goal = _guided(cell, tip_at(hole), generator)
    mouth = _guided(cell, tip_at(hole, TAUGHT_DEPTH), generator)
    return goal, unit(mouth.translation - goal.translation)


def _guided(
    cell: Cell,
    point: np.ndarray,
    generator: np.random.Generator,
) -> Pose:
    """Return what the model sees; the peg is guided into the tight hole with a little play."""
    radius = PLAY * generator.uniform() ** 0.5
    aside = radius * horizontal(generator.uniform(-np.pi, np.pi))
    return cell.model.pose(cell.guide(point + aside))


def insert_at_centre(
    cell: Cell,
    count: int,
    seed: int,
) -> Iterator[Trial[Insertion]]:
    """Insert into the hole that was taught, from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 0])
    goal, out = teach(cell, CENTRE, generator)
    for fraction in stratified(count, generator):
        yield insert(
            cell,
            CENTRE,
            goal,
            out,
            float(fraction),
            generator,
        )


def insert_on_cross(
    cell: Cell,
    count: int,
    seed: int,
) -> Iterator[Trial[Insertion]]:
    """Insert at the first positions of the X; taught are its centre and two branches' ends."""
    generator = np.random.default_rng([seed, 1])
    goal, out = teach(cell, CENTRE, generator)
    axes: list[np.ndarray] = []
    for branch in BRANCHES[::2]:
        end, _ = teach(cell, CENTRE + PER_BRANCH * STEP * branch, generator)
        axis = unit(end.translation - goal.translation)
        axes += [axis, -axis]
    for place, fraction in enumerate(stratified(count, generator)):
        step, branch = divmod(place, len(BRANCHES))
        distance = (1 + step) * STEP
        hole = CENTRE + distance * BRANCHES[branch]
        target = shifted(goal, distance * axes[branch])
        yield insert(
            cell,
            hole,
            target,
            out,
            float(fraction),
            generator,
        )


def insert(
    cell: Cell,
    hole: np.ndarray,
    goal: Pose,
    out: np.ndarray,
    fraction: float,
    generator: np.random.Generator,
) -> Trial[Insertion]:
    """Put the peg into a hole, shape (2,) [m], from 0 to 1 of the elbow's range.

    Goal and direction out of the hole, shape (3,), are those of the model, as :func:`teach` says.
    """
    start = cell.start(tip_at(hole, HOVER), fraction, generator)
    cell.scene.place_hole(hole)
    hover = shifted(goal, HOVER * out)
    down = move("insert", 4.0, hover, goal)
    rest = hold("rest", 1.0, goal)
    log, motion = cell.perform(start, hover, [down, rest], ("insert", "rest"))
    depth = TABLE + HOLE_DEPTH - float(log.tip[-1, 2])
    miss = log.tip[log.during("compensate")[-1]] - tip_at(hole, HOVER)
    result = Insertion.filled(
        motion,
        hole=tuple(hole.tolist()),
        inserted=depth > INSERTED_DEPTH,
        depth=depth,
        miss=tuple(miss.tolist()),
    )
    return Trial(log, result)


def insertion_results(trials: Sequence[Trial[Insertion]]) -> Insertions:
    """Return counts, tracking errors and forces of some insertions, and each by itself."""
    insertions = tuple(trial.result for trial in trials)
    misses = [float(np.linalg.norm(insertion.miss)) for insertion in insertions]
    return Insertions.filled(
        Trials.of(insertions, misses),
        inserted=sum(insertion.inserted for insertion in insertions),
        trials=len(insertions),
        each=insertions,
    )


PAPER = np.array([0.5, 0.0])
"""Of the figure, on the paper [m]."""
SIZE = np.array([0.04, 0.06])
"""Half its extent [m]."""
POINTS = 400
SECONDS = 16.0
"""For the whole figure."""
PEN_HOVER = 0.03
"""Height above the first point from which the pen is put down [m]."""
LINE_EVERY = 20
"""Rows of a log from one point of a result's line to the next."""
PRESS = 0.003
"""Depth below the paper to which the pen is led, against a spring of 2000 N/m [m]."""


def figure(fraction: np.ndarray) -> np.ndarray:
    """Return points of the figure, an eight, from 0 to 1 along it; shape (..., 2) [m]."""
    t = 2 * np.pi * np.asarray(fraction)
    eight = np.stack([np.sin(2 * t), np.sin(t)], axis=-1)
    return PAPER + SIZE * eight


def demonstrate(cell: Cell) -> list[Pose]:
    """Guide the pen along the figure, elbow up; return the poses that the model sees."""
    poses: list[Pose] = []
    points = [np.array([*p, TABLE]) for p in figure(np.linspace(0, 1, POINTS))]
    q = cell.guide(points[0])
    for point in points:
        q = reach(cell.truth, q, pose_above(point))
        poses.append(cell.model.pose(q))
    return poses


def upwards(poses: Sequence[Pose]) -> np.ndarray:
    """Return the unit vector out of the plane in which the model sees the figure, shape (3,)."""
    points = np.array([pose.translation for pose in poses])
    *_, Vt = np.linalg.svd(points - points.mean(axis=0))
    normal = Vt[-1]
    return normal * np.sign(normal[2])


def retrace(
    cell: Cell,
    count: int,
    seed: int,
) -> Iterator[Trial[Retracing]]:
    """Draw the demonstrated figure again from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 3])
    taught = demonstrate(cell)
    up = upwards(taught)
    path = [shifted(pose, -PRESS * up) for pose in taught]
    above = shifted(taught[0], PEN_HOVER * up)
    first = np.array([*figure(np.zeros(())), TABLE + PEN_HOVER])
    lower = move("lower", 2.0, above, path[0])
    draw = Phase("draw", SECONDS, lambda fraction: _along(path, smooth(fraction)))
    for fraction in stratified(count, generator):
        start = cell.start(first, float(fraction), generator)
        log, motion = cell.perform(start, above, [lower, draw], ["draw"])
        yield Trial(log, _retracing(log, motion))


def _along(path: Sequence[Pose], fraction: float) -> Pose:
    """Return the pose at a fraction of a path, 0 to 1."""
    place = fraction * (len(path) - 1)
    before = min(int(place), len(path) - 2)
    return pin.SE3.Interpolate(path[before], path[before + 1], place - before)


def _retracing(log: Log, motion: Motion) -> Retracing:
    path = drawn(log)
    demonstrated = figure(np.linspace(0, 1, 2000))
    distances = np.linalg.norm(path[::4, None] - demonstrated, axis=2)
    is_touching = log.forces("draw") > 0
    points = np.round(path[::LINE_EVERY], 6)
    return Retracing.filled(
        motion,
        tracking_error=float(distances.min(axis=1).mean()),
        touching=float(is_touching.mean()),
        line=tuple((x, y) for x, y in points.tolist()),
    )


def drawn(log: Log) -> np.ndarray:
    """Return the true path of the pen on the paper, row by row, shape (N, 2) [m]."""
    return log.tip[log.during("draw"), :2]


def drawing_results(trials: Sequence[Trial[Retracing]]) -> Drawing:
    """Return the distances between the lines, tracking errors and forces, and each line."""
    lines = np.array([drawn(trial.log) for trial in trials])
    distances = np.linalg.norm(lines[:, None] - lines, axis=3)
    largest = distances.max(axis=(0, 1))
    drawings = tuple(trial.result for trial in trials)
    errors = [drawing.tracking_error for drawing in drawings]
    return Drawing.filled(
        Trials.of(drawings, errors),
        retracings=len(drawings),
        spread=float(largest.mean()),
        max_spread=float(largest.max()),
        each=drawings,
    )

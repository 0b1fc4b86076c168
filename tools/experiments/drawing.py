"""The drawing of Section IV-B: a figure is shown, elbow up, and retraced from other postures."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import pinocchio as pin

from .controller import Pose
from .motion import Cell, Log, Phase, Trial, move, pose_above, reach, shifted, smooth, stratified
from .results import Drawing, Retracing
from .scene import TABLE

CENTRE = np.array([0.5, 0.0])
"""Of the figure, on the paper [m]."""
SIZE = np.array([0.04, 0.06])
"""Half its extent [m]."""
POINTS = 400
SECONDS = 16.0
"""For the whole figure."""
HOVER = 0.03
"""Height above the first point from which the pen is put down [m]."""
LINE_EVERY = 20
"""Rows of a log from one point of a result's line to the next."""
PRESS = 0.003
"""Depth below the paper to which the pen is led, against a spring of 2000 N/m [m]."""


def figure(fraction: np.ndarray) -> np.ndarray:
    """Return points of the figure, an eight, from 0 to 1 along it; shape (..., 2) [m]."""
    t = 2 * np.pi * np.asarray(fraction)
    return CENTRE + SIZE * np.stack([np.sin(2 * t), np.sin(t)], axis=-1)


def demonstrate(cell: Cell) -> list[Pose]:
    """Guide the pen along the figure, elbow up; return the poses that the model sees."""
    poses: list[Pose] = []
    points = figure(np.linspace(0, 1, POINTS))
    q = cell.guide(np.array([*points[0], TABLE]))
    for point in points:
        q = reach(cell.truth, q, pose_above(np.array([*point, TABLE])))
        poses.append(cell.model.pose(q))
    return poses


def upwards(poses: Sequence[Pose]) -> np.ndarray:
    """Return the unit vector out of the plane in which the model sees the figure, shape (3,)."""
    points = np.array([pose.translation for pose in poses])
    normal = np.linalg.svd(points - points.mean(axis=0))[2][-1]
    return normal * np.sign(normal[2])


def retrace(cell: Cell, count: int, seed: int) -> Iterator[Trial[Retracing]]:
    """Draw the demonstrated figure again from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 3])
    shown = demonstrate(cell)
    up = upwards(shown)
    path = [shifted(pose, -PRESS * up) for pose in shown]
    above = shifted(shown[0], HOVER * up)
    first = np.array([*figure(np.zeros(())), TABLE + HOVER])
    for fraction in stratified(count, generator):
        start = cell.start(first, float(fraction), generator)
        lower = move("lower", 2.0, above, path[0])
        draw = Phase("draw", SECONDS, lambda fraction: _along(path, smooth(fraction)))
        log, done = cell.perform(start, above, [lower, draw], ["draw"])
        yield Trial(log, _retracing(log, done))


def _along(path: Sequence[Pose], fraction: float) -> Pose:
    """Return the pose at a fraction of a path, 0 to 1."""
    place = fraction * (len(path) - 1)
    before = min(int(place), len(path) - 2)
    return pin.SE3.Interpolate(path[before], path[before + 1], place - before)


def _retracing(log: Log, done: Mapping[str, float]) -> Retracing:
    path = drawn(log)
    shown = figure(np.linspace(0, 1, 2000))
    off = np.linalg.norm(path[::4, None] - shown, axis=2).min(axis=1)
    points: list[list[float]] = np.round(path[::LINE_EVERY], 6).tolist()
    return Retracing(
        **done,
        tracking_error=float(off.mean()),
        touching=float((log.forces("draw") > 0).mean()),
        line=tuple((x, y) for x, y in points),
    )


def drawn(log: Log) -> np.ndarray:
    """Return the true path of the pen on the paper, row by row, shape (N, 2) [m]."""
    return log.tip[log.during("draw"), :2]


def drawing_results(trials: Sequence[Trial[Retracing]]) -> Drawing:
    """Return the distances between the lines, tracking errors and forces, and each line."""
    pairs = combinations([drawn(trial.log) for trial in trials], 2)
    apart = np.max([np.linalg.norm(one - other, axis=1) for one, other in pairs], axis=0)
    each = tuple(trial.result for trial in trials)
    return Drawing(
        retracings=len(each),
        spread=float(apart.mean()),
        max_spread=float(apart.max()),
        each=each,
        **Drawing.fields_of(each, [one.tracking_error for one in each]),
    )

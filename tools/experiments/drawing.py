"""The drawing experiment of Section IV-B.

A person guides the arm, elbow up, so that a pen draws a figure; the poses are written down by the
model's own forward kinematics. Then the figure is retraced from other postures, and the lines lie
apart by as much as the model contradicts itself.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin

from .cell import TABLE, Cell
from .controller import TABLE_II, Pose
from .motion import Log, Phase, hold, move, smooth
from .postures import pose_above, reach, stratified
from .results import Drawing, Retracing

CENTRE = np.array([0.5, 0.0])
"""Of the figure, on the paper [m]."""
SIZE = np.array([0.04, 0.06])
"""Half its extent [m]."""
POINTS = 400
SECONDS = 16.0
"""For the whole figure."""
HOVER = 0.03
"""Height above the first point from which the pen is put down [m]."""
PRESS = 0.003
"""Depth below the paper to which the pen is led, against a spring of 2000 N/m [m]."""


@dataclass(frozen=True)
class Line:
    """One drawing of the figure."""

    log: Log
    elbow: float
    """The elbow's angle at the start [rad]."""

    @property
    def path(self) -> np.ndarray:
        """True path of the pen on the paper, step by step, shape (N, 2) [m]."""
        return self.log.tip[self.log.during("draw"), :2]

    @property
    def forces(self) -> np.ndarray:
        """Magnitude of the paper's force on the pen, step by step, shape (N,) [N]."""
        return np.linalg.norm(self.log.force[self.log.during("draw")], axis=1)

    @property
    def touching(self) -> np.ndarray:
        """True where the pen touched the paper, step by step, shape (N,)."""
        return self.forces > 0

    @property
    def tracking_error(self) -> float:
        """Mean distance of the line's points from the demonstrated figure [m]."""
        shown = figure(np.linspace(0, 1, 2000))
        points = self.path[::4]
        return float(np.linalg.norm(points[:, None] - shown[None], axis=2).min(axis=1).mean())


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


def retrace(cell: Cell, count: int, seed: int) -> Iterator[Line]:
    """Draw the demonstrated figure again from starts that span the elbow's range."""
    generator = np.random.default_rng([seed, 3])
    shown = demonstrate(cell)
    up = upwards(shown)
    path = [_shifted(pose, -PRESS * up) for pose in shown]
    above = _shifted(shown[0], HOVER * up)
    first = np.array([*figure(np.zeros(()))], dtype=float)
    for fraction in stratified(count, generator):
        start = cell.start(np.array([*first, TABLE + HOVER]), float(fraction), generator)
        log = cell.perform(
            start,
            [
                move("approach", 3.0, cell.model.pose(start), above),
                hold("compensate", TABLE_II.window, above, compensate=True),
                move("lower", 2.0, above, path[0]),
                Phase("draw", SECONDS, lambda fraction: _along(path, smooth(fraction))),
            ],
        )
        yield Line(log, cell.elbow(start))


def _shifted(pose: Pose, offset: np.ndarray) -> Pose:
    return pin.SE3(pose.rotation, pose.translation + offset)


def _along(path: Sequence[Pose], fraction: float) -> Pose:
    """Return the pose at a fraction of a path, 0 to 1."""
    place = fraction * (len(path) - 1)
    before = min(int(place), len(path) - 2)
    return pin.SE3.Interpolate(path[before], path[before + 1], place - before)


def spread(lines: Sequence[Line]) -> np.ndarray:
    """Return the largest distance between any two lines at each moment, shape (N,) [m]."""
    paths = [line.path for line in lines]
    apart = [np.linalg.norm(one - other, axis=1) for one, other in combinations(paths, 2)]
    return np.max(apart, axis=0)


LINE_EVERY = 20
"""Rows of a log from one point of a result's line to the next."""


def drawing_results(lines: Sequence[Line]) -> Drawing:
    """Return the distances between the lines, tracking errors and forces, and each line."""
    apart = spread(lines)
    return Drawing(
        retracings=len(lines),
        spread=float(apart.mean()),
        max_spread=float(apart.max()),
        each=tuple(map(_retracing, lines)),
        **Drawing.fields_of(lines),
    )


def _retracing(line: Line) -> Retracing:
    points: list[list[float]] = np.round(line.path[::LINE_EVERY], 6).tolist()
    return Retracing(
        elbow=line.elbow,
        tracking_error=line.tracking_error,
        touching=float(line.touching.mean()),
        force=float(line.forces.mean()),
        peak_force=float(line.forces.max()),
        line=tuple((x, y) for x, y in points),
    )

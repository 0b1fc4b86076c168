"""Several robots in one world: each is calibrated alone, and what they share ties their bases.

Unknowns are those of each robot, as Gaussians of its own fit, and the poses of frames, the bases
of all robots but the first among them. A socket that two robots visited, and a frame that an
instrument gave them, is one place: the poses follow from it, as those by Kabsch weighted by both
covariances, and the robots learn from each other. What was measured of places is taken back from
the fits that had it, and counts once for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..bayes.inference import FRAME_PRIOR_PRECISION, FitPosterior, Posterior
from ..bayes.model import Gaussian
from ..data import (
    IDENTITY,
    WORLD,
    Places,
    Pose,
    RobotRecordings,
    check_base,
    distance_covariance,
    place_frames,
)
from .sightings import (
    Sightings,
    corner_numbers,
    frame_seen,
    measured_sightings,
    sockets_visited,
)

HELD = 0.1
"""Standard deviation of a frame's turn beyond which it is no Gaussian of a robot's fit [rad]."""
ROUNDS, SETTLED = 10, 1e-10
"""Times at most that all is made linear again, and the largest change of a pose after them."""


@dataclass(frozen=True, eq=False)
class TiedRobots:
    """Robots that were calibrated alone, and where their bases and frames stand."""

    robots: tuple[RobotRecordings, ...]
    places: Places
    """The places of all robots."""
    sockets: tuple[tuple[int, ...], ...]
    """For each robot, the index of each of its sockets among all."""
    fits: tuple[FitPosterior, ...]
    """The robots, each in its own base."""
    poses: tuple[Pose, ...]
    """Pose of each frame in the base of the first robot, the world."""
    around: Gaussian
    """Unknowns of robot after robot, then six of each frame."""

    @cached_property
    def begins(self) -> tuple[int, ...]:
        """The first unknown of each robot, and that of the frames."""
        return tuple(np.cumsum([0, *(len(fit.whole) for fit in self.fits)]).tolist())

    @cached_property
    def arms(self) -> tuple[Posterior, ...]:
        """The posterior of each robot alone."""
        return tuple(fit.arm for fit in self.fits)

    def frame_of(self, robot: int) -> int:
        """Return the index of the frame that is a robot's base."""
        return self.places.frames.index(self.robots[robot].base_frame) if robot else WORLD

    def pose(self, frame: int) -> Pose:
        """Return the pose of a frame in the world."""
        return IDENTITY if frame == WORLD else self.poses[frame]

    def columns(self, frame: int) -> slice | None:
        """Return which unknowns are the pose of a frame; None for the world."""
        begin = self.begins[-1] + 6 * frame
        return None if frame == WORLD else slice(begin, begin + 6)

    def frame_covariance(self, frame: int) -> np.ndarray:
        """Return the covariance of a frame's pose, its turn [rad] first, shape (6, 6)."""
        columns = self.columns(frame)
        return np.zeros((6, 6)) if columns is None else self.around.marginal(columns).covariance

    def centres(self) -> dict[int, np.ndarray]:
        """Return the centre of each socket in the world, by the first robot that visited it [m]."""
        centres = dict[int, np.ndarray]()
        for frame, sockets, fit in zip(self.bases(), self.sockets, self.fits, strict=True):
            places = self.pose(frame).apply(fit.state.centres)
            for socket, centre in zip(sockets, places, strict=True):
                centres.setdefault(socket, centre)
        return centres

    def bases(self) -> list[int]:
        """Return the frame of each robot's base."""
        return [self.frame_of(i) for i in range(len(self.robots))]


def tie(
    robots: Sequence[RobotRecordings],
    places: Places,
    sockets: Sequence[tuple[int, ...]],
    fits: Sequence[FitPosterior],
) -> TiedRobots:
    """Return robots, each of which was calibrated alone, in one world.

    Args:
        robots: Their recordings.
        places: The places of all.
        sockets: For each robot, the index of each of its sockets among all.
        fits: The calibration of each.

    Raises:
        FrameError: Nothing ties a robot or a frame to the first robot.
    """
    free = [_without_measurements(fit) for fit in fits]
    mean = np.concatenate([part.mean for part in free] + [np.zeros(6 * len(places.frames))])
    root = _block_diagonal([part.root for part in free] + [_pose_root(len(places.frames))])
    prior, change = Gaussian(mean, root), mean.copy()
    tied = TiedRobots(tuple(robots), places, tuple(sockets), tuple(fits), (), prior)
    tied = replace(tied, poses=_first_poses(tied))
    size = tied.begins[-1]
    for _ in range(ROUNDS):
        slopes, errors = _equations(tied, change)
        posterior = prior.conditioned(slopes, errors + slopes @ (mean - change))
        steps = posterior.mean[size:].reshape(-1, 6)
        poses = tuple(pose.moved(step) for pose, step in zip(tied.poses, steps, strict=True))
        tied = replace(tied, poses=poses, around=Gaussian(0 * mean, posterior.root))
        change = np.append(posterior.mean[:size], np.zeros(steps.size))
        if np.abs(steps).max() < SETTLED:
            break
    parts = [Gaussian(change, tied.around.root).marginal(rows) for rows in _blocks(tied)]
    told = [fit.changed(part) for fit, part in zip(fits, parts, strict=True)]
    return replace(tied, fits=tuple(told))


def _blocks(tied: TiedRobots) -> list[slice]:
    """Return which unknowns are those of each robot."""
    return [slice(a, b) for a, b in pairwise(tied.begins)]


def _without_measurements(fit: FitPosterior) -> Gaussian:
    """Return the unknowns of a fit, as changes, by its samples alone: lengths are taken back."""
    gaussian = fit.around
    if fit.with_curves is not None:
        gaussian = Gaussian.of(np.zeros(len(fit.whole)), fit.whole)
    return gaussian.conditioned(*fit.state.constraints, count=-1)


def _pose_root(count: int) -> np.ndarray:
    """Return the root of the weak prior of some frames."""
    return np.diag(np.tile(1 / FRAME_PRIOR_PRECISION, count))


def _block_diagonal(blocks: Sequence[np.ndarray]) -> np.ndarray:
    """Return a matrix with blocks along its diagonal."""
    shapes = np.array([block.shape for block in blocks])
    matrix, (rows, columns) = np.zeros(shapes.sum(axis=0)), np.cumsum(shapes, axis=0).T
    for block, row, column in zip(blocks, rows.tolist(), columns.tolist(), strict=True):
        matrix[row - len(block) : row, column - block.shape[1] : column] = block
    return matrix


def _in_base(tied: TiedRobots, robot: int, change: np.ndarray) -> Sightings:
    """Return the sockets that a robot visited, and the frames in which its balls were measured."""
    fit, begin, size = tied.fits[robot], tied.begins[robot], len(change)
    own = change[begin : tied.begins[robot + 1]]
    seen = sockets_visited(fit, tied.sockets[robot], own, size, begin)
    for k, name in enumerate(fit.data.frames):
        measured = (fit.data.measured_in == k) | (fit.data.turned_in == k)
        turn = tied.around.root[begin:][fit.objective.of_frame(k)][:3]
        if measured.any() and np.linalg.norm(turn, axis=1).max() < HELD:
            numbers = corner_numbers(tied.places, tied.places.frames.index(name))
            seen = seen.joined(frame_seen(fit, name, numbers, own, size, begin))
    return seen


def _first_poses(tied: TiedRobots) -> tuple[Pose, ...]:
    """Return first poses of all frames in the world, by the places that they have in common."""
    places, size = tied.places, len(tied.around.mean)
    lines = [f"socket {placement}:{number}" for placement, number in places.labels]
    for name in places.frames:
        lines += 3 * [f"frame {name}"]
    wheres = {item.socket: item.where for item in places.located}
    located = [wheres.get(k, line) for k, line in enumerate(lines)]
    frames = {
        k: measured_sightings(places, k, size).observations(name, located)
        for k, name in ((WORLD, ""), *enumerate(places.frames))
    }
    for i, frame in enumerate(tied.bases()):
        name = f"the base of {tied.robots[i].name}"
        visited = _in_base(tied, i, tied.around.mean).observations(name, lines)
        check_base(frames[frame], visited)
        frames[frame] = visited.joined(frames[frame])
    return tuple(place_frames(list(frames.values()))[1:])


def _equations(tied: TiedRobots, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return slopes, shape (E, n), and errors of all that is known, in standard deviations."""
    places, size = tied.places, len(change)
    seen = list[Sightings]()
    for i, frame in enumerate(tied.bases()):
        visited = _in_base(tied, i, change)
        seen.append(visited.in_world(tied.pose(frame), tied.columns(frame)))
    for frame in (WORLD, *range(len(places.frames))):
        measured = measured_sightings(places, frame, size)
        seen.append(measured.in_world(tied.pose(frame), tied.columns(frame)))
    points, by_unknowns = dict[int, np.ndarray](), dict[int, np.ndarray]()
    slopes, errors = [np.zeros((0, size))], [np.zeros(0)]
    for sightings in seen:
        for k, number in enumerate(sightings.numbers.tolist()):
            if number in points:
                deviation = sightings.deviations[k]
                slopes.append((sightings.slopes[k] - by_unknowns[number]) / deviation)
                errors.append((sightings.points[k] - points[number]) / deviation)
            else:
                points[number], by_unknowns[number] = sightings.points[k], sightings.slopes[k]
    rows, values = np.zeros((len(places.known), size)), np.zeros(len(places.known))
    for i, known in enumerate(places.known):
        offset = points[known.second] - points[known.first]
        length = float(np.linalg.norm(offset))
        rows[i] = offset / length @ (by_unknowns[known.second] - by_unknowns[known.first])
        values[i] = length - known.distance
    whiten = np.linalg.inv(np.linalg.cholesky(distance_covariance(places.known)))
    return np.vstack([*slopes, whiten @ rows]), np.concatenate([*errors, whiten @ values])

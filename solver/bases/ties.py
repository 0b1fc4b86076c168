"""Several robots in one world: each is calibrated alone, and what they share ties their bases.

Unknowns are those of each robot, as the Gaussian of its own fit, and the poses of all frames, the
bases of robots among them. A socket that two robots visited, and a frame in which an instrument
measured both, are places that they share: the poses follow from these, weighted by the covariances
of both, and the robots learn from each other. Known lengths are taken back from the fits of single
robots, and count once for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from ..bayes.inference import FRAME_PRIOR_PRECISION, Posterior
from ..bayes.model import Gaussian
from ..bayes.results import frame_pose
from ..data import (
    IDENTITY,
    WORLD,
    Places,
    Pose,
    check_base,
    distance_covariance,
    place_frames,
)
from ..results import FramePose
from .views import Seen, View, Visitor, view_of_frame

ROUNDS, SETTLED = 10, 1e-10
"""Times at most that all is made linear again, and the largest change of a pose after them."""


@dataclass(frozen=True, eq=False)
class TiedRobots:
    """Robots that were calibrated alone, and where their bases and frames stand."""

    robots: tuple[Visitor, ...]
    places: Places
    """The places of all robots, F frames among them."""
    around: Gaussian
    """Unknowns of robot after robot, then six of each pose, as changes."""
    poses: tuple[Pose, ...]
    """Pose of each frame in the base of the first robot, and at last of that, the world."""

    @cached_property
    def columns(self) -> list[slice]:
        """For each robot, which unknowns are its own."""
        sizes = (len(robot.fit.whole) for robot in self.robots)
        ends = accumulate(sizes, initial=0)
        return [slice(a, b) for a, b in pairwise(ends)]

    @cached_property
    def arms(self) -> tuple[Posterior, ...]:
        """The posterior of each robot alone."""
        return tuple(robot.fit.arm for robot in self.robots)

    def columns_of(self, frame: int) -> slice:
        """Return which unknowns are the pose of a frame."""
        begin = self.columns[-1].stop + 6 * (frame % len(self.poses))
        return slice(begin, begin + 6)

    def frame_covariance(self, frame: int) -> np.ndarray:
        """Return the covariance of a frame's pose, its turn [rad] first, shape (6, 6)."""
        return self.around.marginal(self.columns_of(frame)).covariance

    @property
    def frames(self) -> tuple[FramePose, ...]:
        """The frames but bases; that of the first robot where coordinates are known in it."""
        places = self.places
        bases = {robot.frame for robot in self.robots}
        frames = [k for k in range(len(places.frames)) if k not in bases]
        if any(item.frame == WORLD for item in places.located):
            frames.append(WORLD)
        poses: list[FramePose] = []
        for k in frames:
            name = "" if k == WORLD else places.frames[k]
            points = sum(arm.data.points_in(name) for arm in self.arms)
            covariance = self.frame_covariance(k)
            poses.append(
                frame_pose(places, k, self.poses[k], covariance, self.centres, points)
            )
        return tuple(poses)

    @cached_property
    def centres(self) -> np.ndarray:
        """Centres of all sockets in the world, by the first robot that visited each, (S, 3) [m]."""
        centres = np.empty((self.places.socket_count, 3))
        for robot in reversed(self.robots):
            centres[[*robot.sockets]] = self.poses[robot.frame].apply(
                robot.fit.state.centres
            )
        return centres


def tie(robots: Sequence[Visitor], places: Places) -> TiedRobots:
    """Return robots, each of which was calibrated alone, in one world.

    The equations are made linear at the last poses and changes until the poses stand still. With A
    and e their slopes and errors at the change y, each round is the prior N(m, S) conditioned on
    A x = A y - e.

    Raises:
        FrameError: Nothing ties a robot or a frame to the first robot.
    """
    parts = [
        robot.fit.gaussian.conditioned(*robot.fit.state.constraints, count=-1)
        for robot in robots
    ]
    of_poses = np.tile(1 / FRAME_PRIOR_PRECISION, len(places.frames) + 1)
    of_poses[-6:] = 0.0  # the world stands still
    prior = Gaussian.independent([*parts, Gaussian(0 * of_poses, np.diag(of_poses))])
    tied = TiedRobots(
        tuple(robots), places, prior, (IDENTITY,) * (len(places.frames) + 1)
    )
    tied = replace(tied, poses=_first_poses(tied))
    change = np.zeros(len(prior.mean))
    begin = tied.columns[-1].stop
    for _ in range(ROUNDS):
        A, errors = _equations(tied, change)
        around = prior.conditioned(A, errors + A @ (prior.mean - change))
        steps = around.mean[begin:].reshape(-1, 6)
        poses = tuple(
            pose.moved(step) for pose, step in zip(tied.poses, steps, strict=True)
        )
        tied = replace(tied, around=around, poses=poses)
        change = np.append(around.mean[:begin], np.zeros(steps.size))
        if np.abs(steps).max() < SETTLED:
            break
    updated = [
        replace(robot, fit=robot.fit.changed(tied.around.marginal(rows)))
        for robot, rows in zip(robots, tied.columns, strict=True)
    ]
    return replace(tied, robots=tuple(updated))


def _first_poses(tied: TiedRobots) -> tuple[Pose, ...]:
    """Return first poses of all frames in the world, by the places that they have in common."""
    places = tied.places
    n = len(tied.around.mean)
    frames = {
        k: view_of_frame(places, k, n).seen for k in range(WORLD, len(places.frames))
    }
    for view in _views_of_robots(tied, np.zeros(n)):
        check_base(frames[view.frame], view.seen)
        frames[view.frame] = view.seen.joined(frames[view.frame])
    world, *poses = place_frames([*frames.values()])
    return (*poses, world)


def _views_of_robots(tied: TiedRobots, change: np.ndarray) -> list[View]:
    """Return what each robot sees, at a change of all unknowns, shape (n,)."""
    unknowns = np.eye(len(change))
    return [
        robot.view(tied.places, change[rows], unknowns[rows])
        for robot, rows in zip(tied.robots, tied.columns, strict=True)
    ]


class Equations(NamedTuple):
    """Measurements that are linear in n unknowns, in their standard deviations."""

    slopes: np.ndarray
    """Shape (E, n)."""
    errors: np.ndarray
    """Shape (E,)."""


def _equations(tied: TiedRobots, change: np.ndarray) -> Equations:
    """Return the equations of what robots share, and of known lengths."""
    places = tied.places
    unknowns = np.eye(len(change))
    views = _views_of_robots(tied, change)
    views += [
        view_of_frame(places, k, len(change)) for k in range(WORLD, len(places.frames))
    ]
    placed = [
        view.in_world(tied.poses[view.frame], unknowns[tied.columns_of(view.frame)])
        for view in views
    ]
    world = Seen(*map(np.concatenate, zip(*placed, strict=True)))
    # every socket is seen by a robot, so that the first places are the sockets
    _, first, place = np.unique(world.numbers, return_index=True, return_inverse=True)
    equations = (
        _of_shared_places(world, first[place]),
        _of_lengths(world, first, places),
    )
    return Equations(*map(np.concatenate, zip(*equations, strict=True)))


def _of_shared_places(world: Seen, first: np.ndarray) -> Equations:
    """Return the equations (p_b - p_a) / s = 0 of places that are seen again.

    Args:
        world: L places by their views.
        first: Index of the first view of the same place, shape (L,).
    """
    again = np.flatnonzero(first != np.arange(len(first)))
    before = first[again]
    weights = 1 / world.deviations[again, None]
    errors = (world.points[again] - world.points[before]) * weights
    slopes = (world.slopes[again] - world.slopes[before]) * weights[:, :, None]
    return Equations(slopes.reshape(errors.size, -1), errors.ravel())


def _of_lengths(world: Seen, sockets: np.ndarray, places: Places) -> Equations:
    """Return the equations C^-1/2 (|p_b - p_a| - d) = 0 of known lengths with covariance C.

    ``sockets`` has the index of each socket among the places in the world.
    """
    ends = [[length.first, length.second] for length in places.known]
    first, second = sockets[np.reshape(ends, (-1, 2)).astype(int).T]
    offsets = world.points[second] - world.points[first]
    lengths = np.linalg.norm(offsets, axis=1)
    directions = offsets / lengths[:, None]
    by_offsets = world.slopes[second] - world.slopes[first]
    slopes = np.einsum("ki,kin->kn", directions, by_offsets)
    root = np.linalg.cholesky(distance_covariance(places.known))
    whiten = np.linalg.inv(root)
    errors = lengths - [length.distance for length in places.known]
    return Equations(whiten @ slopes, whiten @ errors)

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
from itertools import accumulate, pairwise, starmap
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    IDENTITY,
    WORLD,
    FrameObservations,
    Places,
    Pose,
    check_base,
    distance_covariance,
    place_frames,
)
from ..identification.inference import FRAME_PRIOR_PRECISION, Posterior
from ..identification.model import Gaussian
from ..results import FramePose
from ..studies import frame_pose, unit
from .places import Seen, View, Visitor, view_of_frame

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
        sizes = [len(robot.fit.whole) for robot in self.robots]
        return [*starmap(slice, pairwise(accumulate(sizes, initial=0)))]

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
        return tuple(map(self._frame_pose, frames))

    def _frame_pose(self, frame: int) -> FramePose:
        """Return a frame with the errors at its sockets."""
        name = "" if frame == WORLD else self.places.frames[frame]
        points = [arm.data.points_in(name) for arm in self.arms]
        return frame_pose(
            self.places,
            frame,
            self.poses[frame],
            self.frame_covariance(frame),
            self.centres,
            points=sum(points),
        )

    @cached_property
    def centres(self) -> np.ndarray:
        """Centres of all sockets in the world, by the first robot that visited each, (S, 3) [m]."""
        centres = np.empty((self.places.socket_count, 3))
        for robot in reversed(self.robots):
            base = self.poses[robot.frame]
            centres[[*robot.sockets]] = base.apply(robot.fit.state.centres)
        return centres


def tie(robots: Sequence[Visitor], places: Places) -> TiedRobots:
    """Return robots, each of which was calibrated alone, in one world.

    The equations are made linear at the last poses and changes until the poses stand still. With A
    and e their slopes and errors at the change y, each round is the prior N(m, S) conditioned on
    A x = A y - e.

    Raises:
        FrameError: Nothing ties a robot or a frame to the first robot.
    """
    prior = _prior(robots, places)
    poses = (IDENTITY,) * (len(places.frames) + 1)
    tied = TiedRobots(tuple(robots), places, prior, poses)
    tied = replace(tied, poses=_first_poses(tied))
    change = np.zeros(len(prior.mean))
    begin = tied.columns[-1].stop
    for _ in range(ROUNDS):
        A, errors = _equations(tied, change)
        at_mean = errors + A @ (prior.mean - change)
        around = prior.conditioned(A, at_mean)
        steps = around.mean[begin:].reshape(-1, 6)
        poses = tuple(map(Pose.moved, tied.poses, steps))
        tied = replace(tied, around=around, poses=poses)
        change = around.mean.copy()
        change[begin:] = 0.0
        if np.abs(steps).max() < SETTLED:
            break
    updated = tuple(
        replace(robot, fit=robot.fit.changed(tied.around.marginal(rows)))
        for robot, rows in zip(robots, tied.columns, strict=True)
    )
    return replace(tied, robots=updated)


def _prior(robots: Sequence[Visitor], places: Places) -> Gaussian:
    """Return what is known before anything is tied, without the known lengths of each fit."""
    parts: list[Gaussian] = []
    for robot in robots:
        constraints = robot.fit.state.constraints
        parts.append(robot.fit.gaussian.conditioned(*constraints, count=-1))
    deviations = np.tile(1 / FRAME_PRIOR_PRECISION, len(places.frames) + 1)
    deviations[-6:] = 0.0  # the world stands still
    of_frames = Gaussian(np.zeros(len(deviations)), np.diag(deviations))
    return Gaussian.independent([*parts, of_frames])


def _first_poses(tied: TiedRobots) -> tuple[Pose, ...]:
    """Return first poses of all frames in the world, by the places that they have in common."""
    places = tied.places
    n = len(tied.around.mean)
    frames: dict[int, FrameObservations] = {}
    for k in range(WORLD, len(places.frames)):
        frames[k] = view_of_frame(places, k, n).seen
    for view in _views_of_robots(tied, np.zeros(n)):
        measured = frames[view.frame]
        check_base(measured, view.seen)
        frames[view.frame] = view.seen.joined(measured)
    world, *poses = place_frames([*frames.values()])
    return (*poses, world)


def _views_of_robots(
    tied: TiedRobots,
    change: np.ndarray,
) -> list[View]:
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
    n = len(change)
    unknowns = np.eye(n)
    views = _views_of_robots(tied, change)
    views += [view_of_frame(places, k, n) for k in range(WORLD, len(places.frames))]
    seen = [
        view.in_world(tied.poses[view.frame], unknowns[tied.columns_of(view.frame)])
        for view in views
    ]
    world = Seen(*map(np.concatenate, zip(*seen, strict=True)))
    # every socket is seen by a robot, so that the first places are the sockets
    _, first, place = np.unique(world.numbers, return_index=True, return_inverse=True)
    shared = _of_shared_places(world, first[place])
    lengths = _of_lengths(world, first, places)
    return Equations(*map(np.concatenate, zip(shared, lengths, strict=True)))


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
    by_unknowns = world.slopes[again] - world.slopes[before]
    slopes = by_unknowns * weights[:, :, None]
    return Equations(slopes.reshape(errors.size, -1), errors.ravel())


def _of_lengths(
    world: Seen,
    sockets: np.ndarray,
    places: Places,
) -> Equations:
    """Return the equations C^-1/2 (|p_b - p_a| - d) = 0 of known lengths with covariance C.

    ``sockets`` has the index of each socket among the places in the world.
    """
    first = sockets[[length.first for length in places.known]]
    second = sockets[[length.second for length in places.known]]
    distances = [length.distance for length in places.known]
    offsets = world.points[second] - world.points[first]
    lengths = np.linalg.norm(offsets, axis=1)
    errors = lengths - distances
    by_offsets = world.slopes[second] - world.slopes[first]
    slopes = np.einsum("ki,kin->kn", unit(offsets), by_offsets)
    whiten = np.linalg.inv(np.linalg.cholesky(distance_covariance(places.known)))
    return Equations(whiten @ slopes, whiten @ errors)

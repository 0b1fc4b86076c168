"""The places of several robots: of all, as each has them alone, and as they are seen in one frame.

A robot sees places in its base; measured coordinates are seen in a frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    CALIPER_DEVIATION,
    WORLD,
    FrameObservations,
    KnownDistance,
    Measurement,
    Places,
    Pose,
    SocketAt,
    measured_in_frame,
    places_of,
)
from ..identification.inference import FitPosterior
from ..results import Measurements


def base_name(measured: Measurement, robots: int) -> str:
    """Return the name of a placement's base: of several robots, one place is one base."""
    return measured.name if robots == 1 else measured.placement.place


def common_places(
    robots: Sequence[Measurements],
    *,
    lengths: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
) -> Places:
    """Return the places of several robots; equal ``Placement.place`` is one base, not moved.

    The world is the base of the first robot; those of others are frames, the last ones. Other
    arguments are those of :func:`.places_of`.
    """
    measured = list[Measurement]()
    for recordings in robots:
        measured += [
            m.called(base_name(m, len(robots))) for m in recordings.measurements
        ]
    world, *bases = [recordings.base_frame for recordings in robots]
    return places_of(
        measured,
        world=world,
        frames=bases,
        lengths=lengths,
        sockets_at=sockets_at,
        deviation=deviation,
    )


def places_alone(
    places: Places,
    robots: Sequence[Measurements],
    robot: int,
) -> tuple[Places, tuple[int, ...]]:
    """Return the places of one of several robots, and its sockets' indices among those of all.

    They have the names of its own placements; coordinates in the base of another robot are left
    out.
    """
    recordings = robots[robot]
    labels = _own_labels(recordings, len(robots))
    sockets = [k for k, label in enumerate(places.labels) if label in labels]
    part = places.at(sockets)
    names = (*places.frames, robots[0].base_frame)
    bases = {arm.base_frame for arm in robots}
    used = {m.frame for m in recordings.measurements if m.kind == "points"}
    used |= {names[item.frame] for item in part.located} - bases
    frames = [name for name in places.frames if name in used]
    indices = {name: k for k, name in enumerate(frames)}
    indices[recordings.base_frame] = WORLD
    places_of_robot = replace(
        part,
        labels=tuple(labels[label] for label in part.labels),
        located=tuple(
            replace(item, frame=indices[names[item.frame]])
            for item in part.located
            if names[item.frame] in indices
        ),
        frames=tuple(frames),
    )
    return places_of_robot, tuple(sockets)


def _own_labels(
    recordings: Measurements,
    robots: int,
) -> dict[tuple[str, int], tuple[str, int]]:
    """Return a robot's own label of each of its sockets, by that among so many robots."""
    labels: dict[tuple[str, int], tuple[str, int]] = {}
    for m in recordings.measurements:
        if m.kind != "sockets":
            continue
        name = base_name(m, robots)
        for socket in m.sockets:
            labels[name, socket] = (m.name, socket)
    return labels


CORNERS = np.eye(3)
"""Points that stand for the pose of a frame [m]."""
HELD = 0.1
"""Standard deviation of a frame's turn beyond which it is no Gaussian of a robot's fit [rad]."""
SAME = 1e-9
"""Standard deviation of the distance from a place to itself [m]."""


class Seen(NamedTuple):
    """L places in the world, by n unknowns."""

    points: np.ndarray
    """Shape (L, 3) [m]."""
    slopes: np.ndarray
    """Their derivatives, shape (L, 3, n)."""
    deviations: np.ndarray
    """Standard deviations beside the unknowns, shape (L,) [m]."""
    numbers: np.ndarray
    """Those of the places, shape (L,)."""


@dataclass(frozen=True)
class View:
    """L places in one frame, by n unknowns."""

    frame: int
    seen: FrameObservations
    """The places: sockets, then the corners of each frame."""
    slopes: np.ndarray
    """Derivatives of their coordinates, shape (L, 3, n)."""
    deviations: np.ndarray
    """Standard deviations beside the unknowns, shape (L,) [m]."""

    def in_world(self, pose: Pose, unknowns: np.ndarray) -> Seen:
        """Return the places in the world, R p + t.

        Args:
            pose: R and t of the frame.
            unknowns: Derivatives of the pose's six numbers by all unknowns, shape (6, n).
        """
        points = self.seen.points
        return Seen(
            points=pose.apply(points),
            slopes=pose.rotation @ self.slopes + pose.slopes(points) @ unknowns,
            deviations=self.deviations,
            numbers=self.seen.numbers,
        )


def view_of_frame(
    places: Places,
    frame: int,
    size: int,
) -> View:
    """Return the sockets with coordinates in a frame, and its corners."""
    deviations = [item.deviation for item in places.located if item.frame == frame]
    name = places.frames[frame] if frame != WORLD else ""
    seen = measured_in_frame(places, frame, name)
    if frame != WORLD:
        seen = seen.joined(_corners(places, name, CORNERS))
        deviations += [SAME] * len(CORNERS)
    slopes = np.zeros((len(deviations), 3, size))
    return View(frame, seen, slopes, np.array(deviations))


@dataclass(frozen=True)
class Visitor:
    """A robot that was calibrated alone, among several."""

    name: str
    frame: int
    """The frame that is its base."""
    sockets: tuple[int, ...]
    """Index of each of its sockets among those of all robots."""
    fit: FitPosterior

    def view(
        self,
        places: Places,
        change: np.ndarray,
        unknowns: np.ndarray,
    ) -> View:
        """Return the sockets that it visited, and the frames in which its balls were measured.

        Args:
            places: Those of all robots.
            change: Of its d unknowns, shape (d,).
            unknowns: Derivatives of these by all unknowns, shape (d, n).
        """
        objective, state = self.fit.objective, self.fit.state
        centres = slice(objective.dense, objective.size)
        seen = self._sockets(places, change[centres])
        slopes = [unknowns[centres].reshape(-1, 3, unknowns.shape[1])]
        for k, name in enumerate(self.fit.data.frames):
            if self._knows(k):
                columns = objective.of_frame(k)
                pose = state.frames[k].moved(change[columns])
                corners = _corners(places, name, pose.apply(CORNERS))
                seen = seen.joined(corners)
                slopes.append(pose.slopes(CORNERS) @ unknowns[columns])
        deviations = np.full(len(seen.points), SAME)
        return View(self.frame, seen, np.concatenate(slopes), deviations)

    def _sockets(
        self,
        places: Places,
        change: np.ndarray,
    ) -> FrameObservations:
        """Return its sockets, after a change of their centres, shape (3 S,) [m]."""
        labels = [places.labels[k] for k in self.sockets]
        return FrameObservations(
            f"the base of {self.name}",
            np.array(self.sockets, dtype=np.int64),
            self.fit.state.centres + change.reshape(-1, 3),
            [f"{self.name}: socket {name}:{socket}" for name, socket in labels],
        )

    def _knows(self, frame: int) -> bool:
        """Tell whether its fit knows how a frame is turned."""
        data = self.fit.data
        is_measured = (data.measured_in == frame) | (data.turned_in == frame)
        covariance = self.fit.frame_covariance(data.frames[frame])
        variance = float(np.trace(covariance[:3, :3]))
        return bool(is_measured.any()) and variance < HELD**2


def _corners(
    places: Places,
    name: str,
    points: np.ndarray,
) -> FrameObservations:
    """Return the corners of a frame by their coordinates, shape (3, 3) [m]."""
    count = len(CORNERS)
    first = places.socket_count + count * places.frames.index(name)
    numbers = first + np.arange(count)
    return FrameObservations(name, numbers, points, count * [f"frame {name}"])

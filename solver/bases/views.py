"""Places as they are seen in one frame: by a robot in its base, or by measured coordinates."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    WORLD,
    FrameObservations,
    Places,
    Pose,
    measured_in_frame,
)
from ..identification.inference import FitPosterior

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
        by_places = pose.rotation @ self.slopes
        by_pose = pose.slopes(points) @ unknowns
        return Seen(
            points=pose.apply(points),
            slopes=by_places + by_pose,
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
        objective = self.fit.objective
        state = self.fit.state
        centres = slice(objective.dense, objective.size)
        seen = self._sockets(places, change[centres])
        of_centres = unknowns[centres]
        size = unknowns.shape[1]
        slopes = [of_centres.reshape(-1, 3, size)]
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
        lines: list[str] = []
        for k in self.sockets:
            placement, socket = places.labels[k]
            lines.append(f"{self.name}: socket {placement}:{socket}")
        numbers = np.array(self.sockets, dtype=np.int64)
        shifts = change.reshape(-1, 3)
        points = self.fit.state.centres + shifts
        name = f"the base of {self.name}"
        return FrameObservations(name, numbers, points, lines)

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
    frame = places.frames.index(name)
    first = places.socket_count + len(CORNERS) * frame
    numbers = first + np.arange(len(CORNERS))
    lines = len(CORNERS) * [f"frame {name}"]
    return FrameObservations(name, numbers, points, lines)

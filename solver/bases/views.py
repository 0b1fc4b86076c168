"""Places as they are seen in one frame: by a robot in its base, or by measured coordinates."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..bayes.inference import FitPosterior
from ..data import WORLD, FrameObservations, Places, Pose, measured_in_frame

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
        slopes = pose.rotation @ self.slopes + pose.slopes(points) @ unknowns
        return Seen(pose.apply(points), slopes, self.deviations, self.seen.numbers)


def view_of_frame(places: Places, frame: int, size: int) -> View:
    """Return the sockets with coordinates in a frame, and its corners."""
    deviations = [item.deviation for item in places.located if item.frame == frame]
    name = places.frames[frame] if frame != WORLD else ""
    seen = measured_in_frame(places, frame, name)
    if frame != WORLD:
        seen = seen.joined(_corners(places, name, CORNERS))
        deviations += [SAME] * len(CORNERS)
    return View(frame, seen, np.zeros((len(deviations), 3, size)), np.array(deviations))


@dataclass(frozen=True)
class Visitor:
    """A robot that was calibrated alone, among several."""

    name: str
    frame: int
    """The frame that is its base."""
    sockets: tuple[int, ...]
    """Index of each of its sockets among those of all robots."""
    fit: FitPosterior

    def view(self, places: Places, change: np.ndarray, unknowns: np.ndarray) -> View:
        """Return the sockets that it visited, and the frames in which its balls were measured.

        Args:
            places: Those of all robots.
            change: Of its d unknowns, shape (d,).
            unknowns: Derivatives of these by all unknowns, shape (d, n).
        """
        fit, objective = self.fit, self.fit.objective
        data, state = fit.data, fit.state
        centres = slice(objective.dense, objective.size)
        labels = [places.labels[k] for k in self.sockets]
        seen = FrameObservations(
            f"the base of {self.name}",
            np.array(self.sockets, dtype=np.int64),
            state.centres + change[centres].reshape(-1, 3),
            [
                f"{self.name}: socket {placement}:{socket}"
                for placement, socket in labels
            ],
        )
        slopes = [unknowns[centres].reshape(-1, 3, unknowns.shape[1])]
        for k, name in enumerate(data.frames):
            measured = (data.measured_in == k) | (data.turned_in == k)
            turn = fit.frame_covariance(name)[:3, :3]
            if measured.any() and np.trace(turn) < HELD**2:
                columns = objective.of_frame(k)
                pose = state.frames[k].moved(change[columns])
                seen = seen.joined(_corners(places, name, pose.apply(CORNERS)))
                slopes.append(pose.slopes(CORNERS) @ unknowns[columns])
        deviations = np.full(len(seen.points), SAME)
        return View(self.frame, seen, np.concatenate(slopes), deviations)


def _corners(places: Places, name: str, points: np.ndarray) -> FrameObservations:
    """Return the corners of a frame by their coordinates, shape (3, 3) [m]."""
    first = places.socket_count + len(CORNERS) * places.frames.index(name)
    numbers = first + np.arange(len(CORNERS))
    lines = len(CORNERS) * [f"frame {name}"]
    return FrameObservations(name, numbers, points, lines)

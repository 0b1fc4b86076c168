"""Places as robots and frames see them: equal numbers are one place in the world."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bayes.inference import FitPosterior
from ..data import WORLD, FrameObservations, Places, Pose

CORNERS = np.eye(3)
"""Points that stand for the pose of a frame [m]."""
SAME = 1e-9
"""Standard deviation of the distance from a place to itself [m]."""


@dataclass(frozen=True)
class Sightings:
    """L places that are seen in one frame, by n unknowns."""

    numbers: np.ndarray
    """Indices of the places, shape (L,): sockets, then the corners of each frame."""
    points: np.ndarray
    """Their coordinates in the frame, shape (L, 3) [m]."""
    slopes: np.ndarray
    """Derivatives of these, shape (L, 3, n)."""
    deviations: np.ndarray
    """Their standard deviations beside the unknowns, shape (L,) [m]."""

    def in_world(self, pose: Pose, columns: slice | None) -> "Sightings":
        """Return them in the world, where some unknowns move the frame's pose."""
        slopes = pose.rotation @ self.slopes
        if columns is not None:
            slopes[:, :, columns] += pose.slopes(self.points)
        return replace(self, points=pose.apply(self.points), slopes=slopes)

    def joined(self, sightings: "Sightings") -> "Sightings":
        """Return these and further ones of the same frame."""
        return Sightings(
            np.concatenate([self.numbers, sightings.numbers]),
            np.concatenate([self.points, sightings.points]),
            np.concatenate([self.slopes, sightings.slopes]),
            np.concatenate([self.deviations, sightings.deviations]),
        )

    def observations(self, name: str, wheres: Sequence[str]) -> FrameObservations:
        """Return them for first poses; ``wheres`` has a line for each place, for messages."""
        numbers: list[int] = self.numbers.tolist()
        lines = [wheres[number] for number in numbers]
        return FrameObservations(name, self.numbers, self.points, lines)


def corner_numbers(places: Places, frame: int) -> np.ndarray:
    """Return the numbers of a frame's corners."""
    count = len(CORNERS)
    return places.socket_count + count * frame + np.arange(count)


def measured_sightings(places: Places, frame: int, size: int) -> Sightings:
    """Return the sockets with coordinates in a frame, and its corners."""
    items = [item for item in places.located if item.frame == frame]
    sockets = np.array([item.socket for item in items], dtype=np.int64)
    coordinates = np.reshape([item.coordinates for item in items], (-1, 3))
    deviations = np.array([item.deviation for item in items], dtype=float)
    measured = Sightings(sockets, coordinates, np.zeros((len(items), 3, size)), deviations)
    if frame == WORLD:
        return measured
    count = len(CORNERS)
    exact, slopes = np.full(count, SAME), np.zeros((count, 3, size))
    return measured.joined(Sightings(corner_numbers(places, frame), CORNERS, slopes, exact))


def sockets_visited(
    fit: FitPosterior, sockets: Sequence[int], change: np.ndarray, size: int, begin: int
) -> Sightings:
    """Return the sockets of a robot in its base after a change of its unknowns.

    ``sockets`` are their indices among those of all robots, ``begin`` is the robot's first unknown
    among n = size.
    """
    count, first = len(sockets), fit.objective.dense
    points = fit.state.centres + change[first : fit.objective.size].reshape(-1, 3)
    slopes = np.zeros((count, 3, size))
    for k in range(count):
        columns = begin + first + 3 * k
        slopes[k, :, columns : columns + 3] = np.eye(3)
    numbers = np.array(sockets, dtype=np.int64)
    return Sightings(numbers, points, slopes, np.full(count, SAME))


def frame_seen(
    fit: FitPosterior, name: str, numbers: np.ndarray, change: np.ndarray, size: int, begin: int
) -> Sightings:
    """Return the corners of a frame in the base of a robot; see :func:`sockets_visited`."""
    columns = fit.objective.of_frame(fit.data.frames.index(name))
    pose = fit.frames[name].moved(change[columns])
    slopes = np.zeros((len(CORNERS), 3, size))
    slopes[:, :, begin + columns.start : begin + columns.stop] = pose.slopes(CORNERS)
    return Sightings(numbers, pose.apply(CORNERS), slopes, np.full(len(CORNERS), SAME))

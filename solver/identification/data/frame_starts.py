"""First poses of the frames of a robot's observations, by its nominal balls."""

import numpy as np

from .frames import FrameObservations, Pose, check_base, place_frames
from .known import WORLD
from .observations import Observations
from .places import measured_in_frame


def first_frames(data: Observations, points: np.ndarray) -> tuple[Pose, ...]:
    """Return first poses of the frames by the nominal robot's balls, shape (N, 3) [m]."""
    if not data.frames and not data.located:
        return ()
    visited = _visited(data, points)
    base = measured_in_frame(data, WORLD, "")
    check_base(base, visited)
    frames = [_measured(data, k, name) for k, name in enumerate(data.frames)]
    return tuple(place_frames([visited.joined(base), *frames])[1:])


def _visited(data: Observations, points: np.ndarray) -> FrameObservations:
    """Return the places that the robot visited: sockets, then measured balls by their row."""
    base = "the base of the robot"
    centres = np.zeros((data.socket_count, 3))
    for k in range(data.socket_count):
        centres[k] = np.median(points[data.sockets == k], axis=0)
    visited = FrameObservations(
        name=base,
        numbers=np.arange(data.socket_count),
        points=centres,
        wheres=[f"socket {name}:{number}" for name, number in data.labels],
    )
    measured = np.flatnonzero(~data.seated & ~data.turned)
    return visited.joined(_balls(data, measured, base, points))


def _balls(
    data: Observations, rows: np.ndarray, name: str, points: np.ndarray
) -> FrameObservations:
    """Return measured balls by their rows, at some points."""
    numbers = data.socket_count + rows
    return FrameObservations(name, numbers, points[rows], data.wheres[rows].tolist())


def _measured(data: Observations, frame: int, name: str) -> FrameObservations:
    """Return the places whose coordinates in a frame were measured."""
    rows = np.flatnonzero(data.measured_in == frame)
    balls = _balls(data, rows, name, data.points)
    return measured_in_frame(data, frame, name).joined(balls)

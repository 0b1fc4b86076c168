"""Plot of several arms at the bases that they share, from above and from the side."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....solver.assessment import joined, nice_above
from ....solver.identification.data import IDENTITY, Pose
from ....solver.identification.robot import Origin
from ....solver.results import ArmsDocument
from ..figures import ReportDocument
from .axis import MM
from .figure import COLOURS, Plot, plot, to_scale
from .panel import Panel

AXIS = 0.12
"""Length of the axes of frames, as a share of the picture."""
ENLARGED = 0.04
"""The largest standard deviation is drawn as this share of the picture, if it is smaller."""
LEAST_RADIUS = 3.0
"""Of the ellipse of a standard deviation, in the panel's units."""


class _View(NamedTuple):
    """A direction in which the arms are seen."""

    title: str
    flat: np.ndarray
    """Directions to the right and up in the picture, as columns, shape (3, 2)."""
    labels: tuple[str, str]


class _Frame(NamedTuple):
    """A frame in the base of the first robot."""

    name: str
    pose: Pose
    deviation: np.ndarray
    """Of its origin, shape (3,) [m]."""


def arms_together(report: ReportDocument) -> Plot | None:
    """Several arms at the bases that they share, from above and from the side."""
    arms = report.arms
    if arms is None or not any(arm.postures for arm in arms.arms):
        return None
    points = [np.reshape(arm.postures, (-1, 3)) for arm in arms.arms if arm.postures]
    postures = np.concatenate(points)
    size = float(np.ptp(postures, axis=0).max())
    frames = _frames(arms)
    factor = _enlargement(frames, size)
    panels: list[Panel] = []
    for view in _views(arms.arms[0].name):
        panel = to_scale(
            view.title,
            postures @ view.flat,
            view.labels,
            room=AXIS * size,
        )
        _draw_arms(panel, view.flat, arms)
        for frame in frames:
            _draw_axes(panel, view.flat, frame, AXIS * size)
            _draw_deviation(panel, view.flat, frame, factor)
        panels.append(panel)
    return plot(
        "arms",
        *panels,
        report=report,
        factor=factor,
        colours=COLOURS,
    )


def _views(first: str) -> Iterator[_View]:
    """Yield the views, in words about the first robot by its name."""
    x, y, z = np.eye(3)
    ahead = f"m ahead of {first}'s base"
    right = f"m to {first}'s right"
    yield _View("from above", np.column_stack([-y, x]), (right, ahead))
    yield _View("from the side", np.column_stack([x, z]), (ahead, "m above it"))


def _enlargement(frames: list[_Frame], size: float) -> float:
    """Return the factor that makes deviations visible in a picture of a size [m], at least 1."""
    largest = max((float(frame.deviation.max()) for frame in frames), default=0.0)
    if not largest:
        return 1.0
    factor = nice_above(ENLARGED * size / largest / 2)
    return max(1.0, factor)


def _frames(arms: ArmsDocument) -> list[_Frame]:
    """Return the frames whose orientation is known: the robots' bases, and those of sockets."""
    bases = zip(arms.robots[1:], arms.between.values(), strict=True)
    turned = [frame for frame in arms.frames if frame.sockets and frame.turn_known]
    tables = [(frame.name, frame) for frame in turned if frame.name != "base"]
    frames = [_Frame(arms.robots[0], IDENTITY, np.zeros(3))]
    for name, base in (*bases, *tables):
        if base.xyz is None or base.rpy is None or base.xyz_deviation is None:
            continue
        pose = Pose.of(Origin(base.xyz, base.rpy))
        deviation = np.array(base.xyz_deviation)
        frames.append(_Frame(name, pose, deviation))
    return frames


def _draw_arms(panel: Panel, flat: np.ndarray, arms: ArmsDocument) -> None:
    for i, arm in enumerate(arms.arms):
        mark = f"arm model-{i % COLOURS}"
        for posture in arm.postures:
            points = np.array(posture) @ flat
            panel.line(points.tolist(), mark)
    for socket in arms.sockets:
        if len(socket.robots) > 1:
            hint = f"{socket.name}, visited by {joined(socket.robots)}"
            x, y = np.array(socket.xyz) @ flat
            panel.dot(x, y, "socket", hint)


def _draw_axes(panel: Panel, flat: np.ndarray, frame: _Frame, length: float) -> None:
    """Draw those axes of a frame that do not point at the viewer, of a length [m]."""
    origin = frame.pose.translation @ flat
    ends = frame.pose.apply(length * np.eye(3)) @ flat
    for end, name in zip(ends, "xyz", strict=True):
        if np.hypot(*(end - origin)) > length / 3:
            panel.line([tuple(origin), tuple(end)], "axis")
            x = panel.x(end[0]) + 3
            y = panel.y(end[1]) + 4
            panel.text(x, y, name, "tick")


def _draw_deviation(
    panel: Panel, flat: np.ndarray, frame: _Frame, factor: float
) -> None:
    """Draw an ellipse of the standard deviation of a frame's origin, enlarged, and its name."""
    a, b = frame.pose.translation @ flat
    across, up = factor * frame.deviation @ np.abs(flat)
    x = panel.x(a)
    y = panel.y(b)
    lengths = " ".join(f"{MM * length:.2f}" for length in frame.deviation)
    panel.add(
        "ellipse",
        f"{frame.name}: +- {lengths} mm",
        cx=x,
        cy=y,
        rx=max(panel.x(a + across) - x, LEAST_RADIUS),
        ry=max(y - panel.y(b + up), LEAST_RADIUS),
        class_="deviation-ellipse",
    )
    panel.text(x, y + 22, frame.name, "strong middle")

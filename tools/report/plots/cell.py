"""Several arms in one picture: how they stood, what both visited, and how well that is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....solver.assessment import joined, nice_above
from ....solver.calibration import pose_of
from ....solver.data import IDENTITY, Pose
from ....solver.results import ArmsDocument, BaseToBase, FramePose
from ....solver.robot import Origin
from ..figures import ReportDocument
from ..page.html import tag
from .axes import Panel, to_scale
from .plot import Plot

AXIS = 0.12
"""How long the axes of frames are drawn, as a share of the picture."""
ENLARGED = 0.04
"""The largest standard deviation is drawn as this share of the picture, if it is smaller."""
COLOURS = 6


@dataclass(frozen=True)
class _Stands:
    """A frame where the picture has it."""

    name: str
    pose: Pose
    deviation: np.ndarray
    """Of its origin, shape (3,) [m]."""


@dataclass(frozen=True)
class _View:
    """Directions in the base of the first robot, and what they are called."""

    title: str
    right: np.ndarray
    up: np.ndarray
    labels: tuple[str, str]

    def flat(self, points: object) -> np.ndarray:
        """Return points as they lie in the picture, shape (..., 2)."""
        return np.array(points, dtype=float) @ np.stack([self.right, self.up], axis=1)


def arms_together(report: ReportDocument) -> Plot | None:
    """Several arms at the bases that they share, from above and from the side."""
    arms = report.arms
    if arms is None or not any(arm.postures for arm in arms.arms):
        return None
    frames = _frames(arms)
    first = arms.arms[0].name
    x, y, z = np.eye(3)
    views = (
        _View("from above", -y, x, (f"m to {first}'s right", f"m ahead of {first}'s base")),
        _View("from the side", x, z, (f"m ahead of {first}'s base", "m above it")),
    )
    drawn = [arm for arm in arms.arms if arm.postures]
    every = np.concatenate([np.reshape(arm.postures, (-1, 3)) for arm in drawn])
    size = float(np.ptp(every, axis=0).max())
    largest = max((float(frame.deviation.max()) for frame in frames), default=0.0)
    factor = max(1.0, nice_above(ENLARGED * size / largest / 2)) if largest else 1.0
    panels = tuple(_drawn(view, arms, frames, every, factor).root for view in views)
    enlarged = f", drawn {factor:g} times as large" if factor > 1 else ""
    return Plot(
        "arms",
        "Arm beside arm at the bases that they share",
        " ".join(one.text for one in arms.between.values()),
        panels,
        (
            *((f"model-{i % COLOURS}", arm.name) for i, arm in enumerate(arms.arms)),
            ("socket", "shared sockets"),
            ("socket-key", f"one standard deviation of a base{enlarged}"),
        ),
    )


def _drawn(
    view: _View,
    arms: ArmsDocument,
    frames: Sequence[_Stands],
    every: np.ndarray,
    factor: float,
) -> Panel:
    size = float(np.ptp(every, axis=0).max())
    panel = to_scale(view.title, view.flat(every), view.labels, room=AXIS * size)
    for i, arm in enumerate(arms.arms):
        for posture in arm.postures:
            panel.line([(a, b) for a, b in view.flat(posture)], f"arm model-{i % COLOURS}")
    for socket in arms.sockets:
        if len(socket.robots) > 1:
            a, b = view.flat(socket.xyz)
            panel.dot(a, b, "socket", f"{socket.name}, visited by {joined(socket.robots)}")
    for frame in frames:
        _draw_frame(panel, view, frame, AXIS * size, factor)
    return panel


def _draw_frame(panel: Panel, view: _View, frame: _Stands, length: float, factor: float) -> None:
    """Draw a frame's axes and name, and an ellipse of its origin's standard deviation."""
    a, b = view.flat(frame.pose.translation)
    ends = view.flat(frame.pose.apply(length * np.eye(3)))
    for end, name in zip(ends, "xyz", strict=True):
        if np.hypot(*(end - (a, b))) > length / 3:
            panel.line([(a, b), tuple(end)], "axis")
            panel.text(panel.x(end[0]) + 3, panel.y(end[1]) + 4, name, "tick")
    radius = np.abs(view.flat(np.diag(factor * frame.deviation))).max(axis=0)
    hint = f"{frame.name}: +- {' '.join(f'{1e3 * d:.2f}' for d in frame.deviation)} mm"
    panel.add(
        "ellipse",
        tag("title", hint),
        cx=panel.x(a),
        cy=panel.y(b),
        rx=max(panel.x(a + radius[0]) - panel.x(a), 3),
        ry=max(panel.y(b) - panel.y(b + radius[1]), 3),
        class_="stands",
    )
    panel.text(panel.x(a), panel.y(b) + 22, frame.name, "strong middle")


def _frames(arms: ArmsDocument) -> list[_Stands]:
    """Return the arms' bases, and the frames of sockets, where the first robot's base is."""
    first = arms.robots[0]
    robots = [_Stands(first, IDENTITY, np.zeros(3))]
    bases = [
        _stands(name, one) for name, one in zip(arms.robots[1:], arms.between.values(), strict=True)
    ]
    tables = [
        _stands(one.name, one)
        for one in arms.frames
        if one.sockets and one.name != "base" and one.turn_known
    ]
    return [*robots, *(frame for frame in (*bases, *tables) if frame is not None)]


def _stands(name: str, one: BaseToBase | FramePose) -> _Stands | None:
    """Return a frame; None where nobody knows how it is turned."""
    if one.xyz is None or one.rpy is None or one.xyz_deviation is None:
        return None
    return _Stands(name, pose_of(Origin(one.xyz, one.rpy)), np.array(one.xyz_deviation))

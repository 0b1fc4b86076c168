"""Plots of the workspace: how well places are known, and several arms at their shared bases."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....solver.assessment import joined, mm, nice_above
from ....solver.calibration import pose_of
from ....solver.data import IDENTITY, Pose
from ....solver.results import ArmsDocument, BaseToBase, FramePose
from ....solver.robot import Origin
from ..figures import ReportDocument
from .figure import Axis, Panel, to_scale
from .plot import COLOURS, Plot

AXIS = 0.12
"""Length of the axes of frames, as a share of the picture."""
ENLARGED = 0.04
"""The largest standard deviation is drawn as this share of the picture, if it is smaller."""
LEVELS = 5
"""Shades of the error map."""


@dataclass(frozen=True)
class _DrawnFrame:
    """A frame in the picture."""

    name: str
    pose: Pose
    deviation: np.ndarray
    """Of its origin, shape (3,) [m]."""


@dataclass(frozen=True)
class _View:
    """Directions in the base of the first robot, and their names."""

    title: str
    right: np.ndarray
    up: np.ndarray
    labels: tuple[str, str]

    def flat(self, points: object) -> np.ndarray:
        """Return points as they lie in the picture, shape (..., 2)."""
        return np.array(points, dtype=float) @ np.stack([self.right, self.up], axis=1)


def error_map(report: ReportDocument) -> Plot | None:
    """Standard deviation of distances from the trained placements to each place, from above."""
    outlook = None if report.outlook is None else report.outlook.map
    if outlook is None:
        return None
    deviations = [deviation for _, _, deviation in outlook.cells]
    least, most = min(deviations), max(deviations)
    reach = max(max(abs(x), abs(y)) for x, y, _ in outlook.cells) + outlook.width
    panel = Panel(
        "predicted error of places, from above",
        Axis(-reach, reach, "m to the robot's right"),
        Axis(-reach, reach, "m ahead of the robot's base"),
        height=468,
    )
    side = panel.x(outlook.width) - panel.x(0) - 1
    for x, y, deviation in outlook.cells:
        level = _level(deviation, least, most)
        panel.add(
            "rect",
            x=panel.x(-y) - side / 2,
            y=panel.y(x) - side / 2,
            width=side,
            height=side,
            class_=f"known-{level}",
        )
    panel.grid()
    panel.dot(0, 0, "base", "the robot's base", size=7)
    for row in report.placements:
        if row.role == "train":
            panel.dot(-row.position[1], row.position[0], "socket", row.name, size=4)
    step = (most - least) / LEVELS
    shades = tuple(
        (f"known-{i}", f"{mm(least + i * step)} to {mm(least + (i + 1) * step)}")
        for i in range(LEVELS)
    )
    far = max(outlook.cells, key=lambda cell: cell[2])
    return Plot(
        "error-map",
        "How well each place is known",
        f"Seen from what was trained on, the distance to a place is known to {mm(least)} at best "
        f"and to {mm(most)} at worst, about x {far[0]:+.2f}, y {far[1]:+.2f} m (one standard "
        "deviation, median over random poses at all heights).",
        (panel,),
        (*shades, ("base", "the robot's base"), ("socket", "trained on")),
        "half",
    )


def _level(deviation: float, least: float, most: float) -> int:
    share = (deviation - least) / max(most - least, 1e-12)
    return min(int(LEVELS * share), LEVELS - 1)


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
    panels = tuple(_drawn(view, arms, frames, every, factor) for view in views)
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
    frames: Sequence[_DrawnFrame],
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


def _draw_frame(
    panel: Panel, view: _View, frame: _DrawnFrame, length: float, factor: float
) -> None:
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
        hint,
        cx=panel.x(a),
        cy=panel.y(b),
        rx=max(panel.x(a + radius[0]) - panel.x(a), 3),
        ry=max(panel.y(b) - panel.y(b + radius[1]), 3),
        class_="deviation-ellipse",
    )
    panel.text(panel.x(a), panel.y(b) + 22, frame.name, "strong middle")


def _frames(arms: ArmsDocument) -> list[_DrawnFrame]:
    """Return the arms' bases, and the frames of sockets, where the first robot's base is."""
    first = arms.robots[0]
    robots = [_DrawnFrame(first, IDENTITY, np.zeros(3))]
    bases = [
        _drawn_frame(name, one)
        for name, one in zip(arms.robots[1:], arms.between.values(), strict=True)
    ]
    tables = [
        _drawn_frame(one.name, one)
        for one in arms.frames
        if one.sockets and one.name != "base" and one.turn_known
    ]
    return [*robots, *(frame for frame in (*bases, *tables) if frame is not None)]


def _drawn_frame(name: str, one: BaseToBase | FramePose) -> _DrawnFrame | None:
    """Return a frame; None where its orientation is unknown."""
    if one.xyz is None or one.rpy is None or one.xyz_deviation is None:
        return None
    return _DrawnFrame(name, pose_of(Origin(one.xyz, one.rpy)), np.array(one.xyz_deviation))

"""Plots of the workspace: how well places are known, several arms together, and the arm's poses."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....solver.assessment import joined, nice_above
from ....solver.data import IDENTITY, Pose
from ....solver.results import ArmsDocument
from ....solver.robot import Origin
from ..figures import ReportDocument
from .axis import Axis
from .figure import COLOURS, FROM_ABOVE, Panel, Plot, from_above, plot, to_scale

AXIS = 0.12
"""Length of the axes of frames, as a share of the picture."""
ENLARGED = 0.04
"""The largest standard deviation is drawn as this share of the picture, if it is smaller."""
LEVELS = 5
"""Shades of the error map."""


def error_map(report: ReportDocument) -> Plot | None:
    """Standard deviation of distances from the trained placements to each place, from above."""
    outlook = None if report.outlook is None else report.outlook.map
    if outlook is None:
        return None
    places = from_above(outlook.cells)
    deviations = np.array([deviation for _, _, deviation in outlook.cells])
    lowest = float(deviations.min())
    highest = float(deviations.max())
    shares = (deviations - lowest) / max(highest - lowest, 1e-12)
    levels = (LEVELS * shares).astype(int)
    reach = float(np.abs(places).max()) + outlook.width
    axes = [Axis(-reach, reach, label) for label in FROM_ABOVE]
    panel = Panel("predicted error of places, from above", *axes, height=468)
    side = panel.x(outlook.width) - panel.x(0) - 1
    for (x, y), level in zip(places.tolist(), levels.clip(max=LEVELS - 1), strict=True):
        panel.square(panel.x(x), panel.y(y), side, class_=f"known-{level}")
    limits = {row.name: row.limit for row in report.verdict.limits}
    limit = limits.get("predicted_distance")
    if limit is not None:
        _outline(panel, places[deviations > limit].tolist(), outlook.width)
    panel.grid()
    panel.dot(0, 0, "base", "the robot's base", size=7)
    for row in report.placements:
        if row.role == "train":
            ahead, left, _ = row.position
            panel.dot(-left, ahead, "socket", row.name, size=4)
    return plot(
        "error-map",
        panel,
        layout="half",
        ends=np.linspace(lowest, highest, LEVELS + 1).tolist(),
        far=outlook.cells[int(deviations.argmax())],
        limit=limit,
    )


def _outline(panel: Panel, cells: Sequence[Sequence[float]], width: float) -> None:
    """Draw a dashed line round cells by their centres, which lie half a cell from the axes."""
    inside = {(x // width, y // width) for x, y in cells}
    half = width / 2
    for x, y in cells:
        for a, b in ((0, 1), (0, -1), (-1, 0), (1, 0)):
            if (x // width + a, y // width + b) not in inside:
                begin = x + half * (a - b), y + half * (b + a)
                end = x + half * (a + b), y + half * (b - a)
                panel.line([begin, end], "threshold")


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
    first = arms.arms[0].name
    frames = _frames(arms)
    points = [np.reshape(arm.postures, (-1, 3)) for arm in arms.arms if arm.postures]
    postures = np.concatenate(points)
    size = float(np.ptp(postures, axis=0).max())
    largest = max((float(frame.deviation.max()) for frame in frames), default=0.0)
    factor = max(1.0, nice_above(ENLARGED * size / largest / 2)) if largest else 1.0
    x, y, z = np.eye(3)
    views = (
        (
            "from above",
            (-y, x),
            (f"m to {first}'s right", f"m ahead of {first}'s base"),
        ),
        ("from the side", (x, z), (f"m ahead of {first}'s base", "m above it")),
    )
    panels: list[Panel] = []
    for title, directions, labels in views:
        flat = np.stack(directions, axis=1)
        panel = to_scale(title, postures @ flat, labels, room=AXIS * size)
        _draw_arms(panel, flat, arms)
        for frame in frames:
            _draw_frame(panel, flat, frame, AXIS * size, factor)
        panels.append(panel)
    return plot("arms", *panels, report=report, factor=factor, colours=COLOURS)


def _frames(arms: ArmsDocument) -> list[_Frame]:
    """Return the frames whose orientation is known: the robots' bases, and those of sockets."""
    bases = zip(arms.robots[1:], arms.between.values(), strict=True)
    known = [frame for frame in arms.frames if frame.sockets and frame.turn_known]
    tables = [(frame.name, frame) for frame in known if frame.name != "base"]
    frames = [_Frame(arms.robots[0], IDENTITY, np.zeros(3))]
    for name, base in (*bases, *tables):
        if (
            base.xyz is not None
            and base.rpy is not None
            and base.xyz_deviation is not None
        ):
            pose = Pose.of(Origin(base.xyz, base.rpy))
            frames.append(_Frame(name, pose, np.array(base.xyz_deviation)))
    return frames


def _draw_arms(panel: Panel, flat: np.ndarray, arms: ArmsDocument) -> None:
    for i, arm in enumerate(arms.arms):
        for posture in arm.postures:
            panel.line((np.array(posture) @ flat).tolist(), f"arm model-{i % COLOURS}")
    for socket in arms.sockets:
        if len(socket.robots) > 1:
            hint = f"{socket.name}, visited by {joined(socket.robots)}"
            x, y = np.array(socket.xyz) @ flat
            panel.dot(x, y, "socket", hint)


def _draw_frame(
    panel: Panel, flat: np.ndarray, frame: _Frame, length: float, factor: float
) -> None:
    """Draw a frame's axes and name, and an ellipse of its origin's standard deviation."""
    a, b = frame.pose.translation @ flat
    ends = frame.pose.apply(length * np.eye(3)) @ flat
    for end, name in zip(ends, "xyz", strict=True):
        if np.hypot(*(end - (a, b))) > length / 3:
            panel.line([(a, b), tuple(end)], "axis")
            panel.text(panel.x(end[0]) + 3, panel.y(end[1]) + 4, name, "tick")
    across, up = factor * frame.deviation @ np.abs(flat)
    x = panel.x(a)
    y = panel.y(b)
    radii = {"rx": max(panel.x(a + across) - x, 3), "ry": max(y - panel.y(b + up), 3)}
    hint = f"{frame.name}: +- {' '.join(f'{1e3 * d:.2f}' for d in frame.deviation)} mm"
    panel.add("ellipse", hint, cx=x, cy=y, **radii, class_="deviation-ellipse")
    panel.text(x, y + 22, frame.name, "strong middle")


def arm_in_3d(report: ReportDocument) -> Plot:
    """The arm in its recorded configurations, nominal against calibrated."""
    arm = report.arm
    count = len(arm.placements)
    factor = arm.exaggeration
    factors = [
        (k, f"{k:g} x" if k != 1 else "true")
        for k in sorted({1.0, factor, 10 * factor})
    ]
    return plot(
        "arm-3d",
        layout="scenes one",
        scene="arm",
        controls={"configurations": count, "factor": factor, "factors": factors},
        report=report,
    )

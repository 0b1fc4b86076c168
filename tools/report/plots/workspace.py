"""Plots of arms in space: how well places are known, an arm in its poses, and several arms."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....solver.assessment import joined, nice_above
from ....solver.identification.data import IDENTITY, Pose
from ....solver.identification.robot import Origin
from ....solver.results import ArmsDocument
from ..figures import ReportDocument
from .axis import MM, Axis
from .figure import COLOURS, FROM_ABOVE, Plot, from_above, plot, to_scale
from .panel import Panel

LEVELS = 5
"""Shades of the error map."""
NEIGHBOURS = ((0, 1), (0, -1), (-1, 0), (1, 0))
"""Steps from a cell of the map to those that it shares an edge with."""


def error_map(report: ReportDocument) -> Plot | None:
    """Standard deviation of distances from the trained placements to each place, from above."""
    outlook = report.outlook and report.outlook.map
    if outlook is None:
        return None
    places = from_above(outlook.cells)
    deviations = np.array([deviation for _, _, deviation in outlook.cells])
    reach = float(np.abs(places).max()) + outlook.width
    axes = [Axis(-reach, reach, label) for label in FROM_ABOVE]
    panel = Panel("predicted error of places, from above", *axes, height=468)
    lowest, highest = float(deviations.min()), float(deviations.max())
    shares = (deviations - lowest) / max(highest - lowest, 1e-12)
    levels = (LEVELS * shares).astype(int).clip(max=LEVELS - 1)
    side = panel.x(outlook.width) - panel.x(0) - 1
    for (x, y), level in zip(places.tolist(), levels, strict=True):
        panel.square(panel.x(x), panel.y(y), side, class_=f"known-{level}")
    limits = {row.name: row.limit for row in report.verdict.limits}
    limit = limits.get("predicted_distance")
    if limit is not None:
        _outline(panel, places[deviations > limit].tolist(), outlook.width)
    panel.grid()
    panel.dot(0, 0, "base", "the robot's base", size=7)
    for row in report.placements:
        if row.role != "test":
            ahead, left, _ = row.position
            panel.dot(-left, ahead, "socket", row.name, size=4)
    ends = np.linspace(lowest, highest, LEVELS + 1)
    return plot(
        "error-map",
        panel,
        layout="half",
        ends=ends.tolist(),
        far=outlook.cells[int(deviations.argmax())],
        limit=limit,
    )


def _outline(panel: Panel, cells: Sequence[Sequence[float]], width: float) -> None:
    """Draw a dashed line round cells by their centres, which lie half a cell from the axes."""
    indices = {(x // width, y // width) for x, y in cells}
    half = width / 2
    for x, y in cells:
        for a, b in NEIGHBOURS:
            neighbour = (x // width + a, y // width + b)
            if neighbour in indices:
                continue
            begin = (x + half * (a - b), y + half * (b + a))
            end = (x + half * (a + b), y + half * (b - a))
            panel.line([begin, end], "threshold")


def arm_in_3d(report: ReportDocument) -> Plot:
    """The arm in its recorded configurations, nominal against calibrated."""
    arm = report.arm
    factor = arm.exaggeration
    words = {value: f"{value:g} x" for value in sorted({1.0, factor, 10 * factor})}
    controls = {
        "configurations": len(arm.placements),
        "factor": factor,
        "factors": list((words | {1.0: "true"}).items()),
    }
    layout = "scenes one"
    return plot(
        "arm-3d",
        layout=layout,
        scene="arm",
        controls=controls,
        report=report,
    )


AXIS = 0.12
"""Length of the axes of frames, as a share of the picture."""
ENLARGED = 0.04
"""The largest standard deviation is drawn as this share of the picture, if it is smaller."""
LEAST_RADIUS = 3.0
"""Of the ellipse of a standard deviation, in the panel's units."""


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
    largest = max(float(frame.deviation.max()) for frame in frames)
    factor = max(1.0, nice_above(ENLARGED * size / largest / 2)) if largest else 1.0
    first = arms.arms[0].name
    ahead = f"m ahead of {first}'s base"
    x, y, z = np.eye(3)  # a view's directions to the right and up are columns, (3, 2)
    views = (
        ("from above", (-y, x), (f"m to {first}'s right", ahead)),
        ("from the side", (x, z), (ahead, "m above it")),
    )
    panels: list[Panel] = []
    for title, directions, labels in views:
        flat = np.column_stack(directions)
        panel = to_scale(title, postures @ flat, labels, room=AXIS * size)
        _draw_arms(panel, flat, arms)
        for frame in frames:
            _draw_axes(panel, flat, frame, AXIS * size)
            _draw_deviation(panel, flat, frame, factor)
        panels.append(panel)
    return plot(
        "arms",
        *panels,
        report=report,
        factor=factor,
        colours=COLOURS,
    )


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
        frames.append(_Frame(name, pose, np.array(base.xyz_deviation)))
    return frames


def _draw_arms(panel: Panel, flat: np.ndarray, arms: ArmsDocument) -> None:
    for i, arm in enumerate(arms.arms):
        mark = f"arm model-{i % COLOURS}"
        for posture in arm.postures:
            panel.line((np.array(posture) @ flat).tolist(), mark)
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

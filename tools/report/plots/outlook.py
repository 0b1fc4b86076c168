"""Plots of what a calibration is worth: how well each place is known, and which joint matters."""

from ....solver.assessment import joined, mm
from ....solver.results import Outlook
from ..figures import ReportDocument
from .axes import Axis, Panel, Rows
from .plot import Plot

LEVELS = 5
"""Shades of the map."""


def error_map(report: ReportDocument) -> Plot | None:
    """How well distances from where was trained to each place are known, from above."""
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
        (panel.root,),
        (*shades, ("base", "the robot's base"), ("socket", "trained on")),
        "half",
    )


def _level(deviation: float, least: float, most: float) -> int:
    share = (deviation - least) / max(most - least, 1e-12)
    return min(int(LEVELS * share), LEVELS - 1)


def joints(report: ReportDocument) -> Plot | None:
    """How far each joint's calibrated numbers move the ball."""
    if report.outlook is None or not report.outlook.joints:
        return None
    rows = report.outlook.joints
    high = 1e3 * max(max(row.recorded, row.workspace) for row in rows)
    names = [row.joint for row in rows]
    panel = Rows("what each joint moves the ball by, mm", names, Axis(0, 1.05 * high, "mm"))
    for i, row in enumerate(rows):
        panel.span(i, 0, 1e3 * row.workspace, "link", thick=14)
        panel.span(i, 0, 1e3 * row.recorded, "change", thick=7)
    return Plot(
        "joints",
        "Which joint matters",
        _joint_sentence(report.outlook),
        (panel.root,),
        (("change", "in what was recorded"), ("link", "in random poses")),
        "half",
    )


def _joint_sentence(outlook: Outlook) -> str:
    rows = sorted(outlook.joints, key=lambda row: -row.recorded)[:2]
    parts = [f"{mm(row.recorded)} (without that of {row.joint})" for row in rows]
    return f"Without a joint's correction the recorded balls are off by up to {joined(parts)}."

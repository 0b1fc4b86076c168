"""Plots of the workspace: how well places are known, and the arm in its poses."""

from collections.abc import Sequence

import numpy as np

from ..figures import ReportDocument
from .axis import Axis
from .figure import FROM_ABOVE, Plot, from_above, plot
from .panel import Panel

LEVELS = 5
"""Shades of the error map."""
NEIGHBOURS = ((0, 1), (0, -1), (-1, 0), (1, 0))
"""Steps from a cell of the map to those that it shares an edge with."""


def error_map(report: ReportDocument) -> Plot | None:
    """Standard deviation of distances from the trained placements to each place, from above."""
    outlook = None if report.outlook is None else report.outlook.map
    if outlook is None:
        return None
    places = from_above(outlook.cells)
    deviations = np.array([deviation for _, _, deviation in outlook.cells])
    reach = float(np.abs(places).max()) + outlook.width
    axes = [Axis(-reach, reach, label) for label in FROM_ABOVE]
    panel = Panel("predicted error of places, from above", *axes, height=468)
    _shade(panel, places, deviations, outlook.width)
    limits = {row.name: row.limit for row in report.verdict.limits}
    limit = limits.get("predicted_distance")
    if limit is not None:
        beyond = places[deviations > limit]
        _outline(panel, beyond.tolist(), outlook.width)
    panel.grid()
    panel.dot(0, 0, "base", "the robot's base", size=7)
    for row in report.placements:
        if row.role != "test":
            ahead, left, _ = row.position
            panel.dot(-left, ahead, "socket", row.name, size=4)
    lowest = float(deviations.min())
    highest = float(deviations.max())
    ends = np.linspace(lowest, highest, LEVELS + 1)
    return plot(
        "error-map",
        panel,
        layout="half",
        ends=ends.tolist(),
        far=outlook.cells[int(deviations.argmax())],
        limit=limit,
    )


def _shade(
    panel: Panel, places: np.ndarray, deviations: np.ndarray, width: float
) -> None:
    """Draw a square of some width for each cell, the darker the larger its deviation [m]."""
    lowest = float(deviations.min())
    span = float(deviations.max()) - lowest
    shares = (deviations - lowest) / max(span, 1e-12)
    levels = (LEVELS * shares).astype(int)
    levels = levels.clip(max=LEVELS - 1)
    side = panel.x(width) - panel.x(0) - 1
    for (x, y), level in zip(places.tolist(), levels, strict=True):
        panel.square(
            panel.x(x),
            panel.y(y),
            side,
            class_=f"known-{level}",
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
    factors: list[tuple[float, str]] = []
    for choice in sorted({1.0, factor, 10 * factor}):
        words = "true" if choice == 1 else f"{choice:g} x"
        factors.append((choice, words))
    controls = {
        "configurations": len(arm.placements),
        "factor": factor,
        "factors": factors,
    }
    return plot(
        "arm-3d",
        layout="scenes one",
        scene="arm",
        controls=controls,
        report=report,
    )

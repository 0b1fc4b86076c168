"""Tables of errors and parameters in millimetres, the same on a terminal and in a pipe."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ...solver.calibration import HEADS, error_rows, errors_title, millimetres
from ...solver.data import Metrics
from ...solver.results import FramePose
from ...solver.results.calibration import ParameterValue, PlacementErrors, Summaries
from ...solver.robot import COMPONENTS


def metrics_table(placements: Sequence[PlacementErrors], summaries: Summaries) -> Table:
    """Return nominal and calibrated errors of every placement, and the summaries [mm]."""
    table = _table(errors_title(placements))
    table.add_column(HEADS[0], overflow="fold", min_width=16)
    for head in HEADS[1:]:
        table.add_column(head, justify="right", no_wrap=True)
    for summed, cells in error_rows(placements, summaries):
        table.add_row(*cells, style="bold" if summed else None)
    return table


def _table(title: str) -> Table:
    return Table(box=SIMPLE_HEAD, title=title, title_justify="left", padding=(0, 1, 0, 0))


def frame_lines(frames: Sequence[FramePose]) -> list[str]:
    """Return where each frame stands, and how well that is known, a line each."""
    lines: list[str] = []
    for frame in frames:
        off = ""
        if frame.socket_error is not None:
            sockets = f"{frame.sockets} socket{'s are' if frame.sockets > 1 else ' is'}"
            off = f"; its {sockets} {millimetres(frame.socket_error)} mm off (rms)"
        if frame.name == "base":
            lines.append(f"Frame base: the robot's own{off}.")
            continue
        if not frame.turn_known:
            lines.append(
                f"Frame {frame.name}: direction unknown{off}; it needs three places or more that "
                "are not on one line."
            )
            continue
        place = " ".join(f"{1e3 * v:+.2f}" for v in frame.xyz)
        deviation = millimetres(max(frame.xyz_deviation))
        turned = " ".join(f"{math.degrees(v):+.3f}" for v in frame.rpy)
        lines.append(
            f"Frame {frame.name} stands at {place} mm (+- {deviation}), turned "
            f"{turned} deg (+- {math.degrees(max(frame.turn_deviation)):.3f}) in the base{off}."
        )
    return lines


def parameters_table(rows: Sequence[ParameterValue]) -> Table:
    """Return what the calibration changed, in mm and mrad; one line a joint."""
    table = _table("change of the joint origins, in mm and mrad")
    table.add_column("joint", overflow="fold")
    for component in COMPONENTS:
        table.add_column(component, justify="right", no_wrap=True)
    changes = {(row.joint, row.component): row.change for row in rows}
    for joint in dict.fromkeys(row.joint for row in rows):
        cells = [
            f"{1e3 * changes[joint, c]:+.3f}" if (joint, c) in changes else "fixed"
            for c in COMPONENTS
        ]
        table.add_row(joint, *cells)
    return table


def left_out_table(result: Mapping[str, Any]) -> Table:
    """Return the errors in each placement when it was left out [mm]."""
    table = _table("errors in mm of each placement, trained on all others")
    table.add_column("placement", overflow="fold")
    for title in HEADS[2:]:
        table.add_column(title, justify="right")
    table.add_column("MAE of the URDF alone", justify="right")
    spreads = {row["name"]: row["standard_deviation"] for row in result.get("bootstrap", [])}
    if spreads:
        table.add_column("MAE over bootstrap fits to all", justify="right")
    rows: list[Mapping[str, Any]] = [*result["left_out"], {"name": "= mean", **result["summary"]}]
    for row in rows:
        cells = [millimetres(row[field.name]) for field in fields(Metrics)]
        cells.append(millimetres(row["loaded"]["mean_absolute_error"]))
        if spreads:
            cells.append(
                f"+- {millimetres(spreads[row['name']])}" if row["name"] in spreads else ""
            )
        table.add_row(row["name"], *cells)
    return table


def matrix_table(matrix: Mapping[str, Any]) -> Table:
    """Return the mean absolute errors, trained on the row's placement alone [mm]."""
    table = _table("MAE in mm: trained on the row's placement alone, measured on the column's")
    table.add_column("", overflow="fold")
    for i in range(len(matrix["names"])):
        table.add_column(f"{i + 1}", justify="right")
    for i, (name, row) in enumerate(zip(matrix["names"], matrix["matrix"], strict=True)):
        values = row or [None] * len(matrix["names"])  # a fit that did not settle has none
        cells = [f"({millimetres(v)})" if i == j else millimetres(v) for j, v in enumerate(values)]
        table.add_row(f"{i + 1} {name}", *cells)
    return table

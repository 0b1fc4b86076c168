"""Tables of errors and parameters in millimetres, the same on a terminal and in a pipe."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ..solver.data.metrics import Metrics
from ..solver.robot.parameters import COMPONENTS
from .documents.arms import FramePose
from .documents.calibration import (
    ParameterValue,
    PlacementErrors,
    Role,
    Summaries,
    Summary,
)

__all__ = ["frame_lines", "left_out_table", "matrix_table", "metrics_table", "parameters_table"]

_COLUMNS = ("MAE", "max", "distance")


def metrics_table(placements: Sequence[PlacementErrors], summaries: Summaries) -> Table:
    """Return nominal and calibrated errors of every placement, and the summaries [mm]."""
    two = any(row.geometric is not None for row in placements)
    title = "errors in mm, nominal > calibrated"
    table = _table(f"{title}.urdf; below, with joint positions corrected first" if two else title)
    table.add_column("placement", overflow="fold", min_width=16)
    table.add_column("samples", justify="right", no_wrap=True)
    for title in _COLUMNS:
        table.add_column(title, justify="right", no_wrap=True)
    parts: tuple[tuple[Role, str, Summary | None], ...] = (
        ("train", "trained on", summaries.train),
        ("test", "held out", summaries.test),
    )
    for role, title, summary in parts:
        for row in placements:
            if row.role == role:
                name = row.name if row.kind == "sockets" else f"{row.name} (true error)"
                table.add_row(name, "+".join(map(str, row.samples)), *_cells(row))
                _add_full(table, row)
        if summary is not None:
            removed = f"{100 * _removed(summary):.1f} % less"
            table.add_row(f"= {title}", removed, *_cells(summary), style="bold")
            _add_full(table, summary)
            table.add_section()
    return table


def _add_full(table: Table, row: PlacementErrors | Summary) -> None:
    """Add the errors of the full model, where the URDF is not all of it."""
    if row.geometric is not None:
        cells = [f"> {_mm(value)}" for value in _figures(row.calibrated)]
        table.add_row("  with corrected joints", "", *cells)


def _removed(summary: Summary) -> float:
    """Return the share of the error that the URDF removes."""
    before, after = summary.nominal.mean_absolute_error, summary.loaded.mean_absolute_error
    return 1 - after / before if before > 0 else 0.0


def _table(title: str) -> Table:
    return Table(box=SIMPLE_HEAD, title=title, title_justify="left", padding=(0, 1, 0, 0))


def _cells(row: PlacementErrors | Summary) -> list[str]:
    pairs = zip(_figures(row.nominal), _figures(row.loaded), strict=True)
    return [f"{_mm(before)} > {_mm(after)}" for before, after in pairs]


def _figures(metrics: Metrics) -> tuple[float, float, float | None]:
    """Return the figures of the columns [m]."""
    return metrics.mean_absolute_error, metrics.max_error, metrics.distance_error


def _mm(metres: float | None) -> str:
    return "-" if metres is None else f"{1e3 * metres:.3f}"


def frame_lines(frames: Sequence[FramePose]) -> list[str]:
    """Return where each frame stands, and how well that is known, a line each."""
    lines: list[str] = []
    for frame in frames:
        off = ""
        if frame.socket_error is not None:
            sockets = f"{frame.sockets} socket{'s are' if frame.sockets > 1 else ' is'}"
            off = f"; its {sockets} {_mm(frame.socket_error)} mm off (rms)"
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
        turned = " ".join(f"{math.degrees(v):+.3f}" for v in frame.rpy)
        lines.append(
            f"Frame {frame.name} stands at {place} mm (+- {_mm(max(frame.xyz_deviation))}), turned "
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
    for title in _COLUMNS:
        table.add_column(title, justify="right")
    table.add_column("MAE of the URDF alone", justify="right")
    spreads = {row["name"]: row["standard_deviation"] for row in result.get("bootstrap", [])}
    if spreads:
        table.add_column("MAE over bootstrap fits to all", justify="right")
    rows: list[Mapping[str, Any]] = [*result["left_out"], {"name": "= mean", **result["summary"]}]
    for row in rows:
        cells = [_mm(row[field.name]) for field in fields(Metrics)]
        cells.append(_mm(row["loaded"]["mean_absolute_error"]))
        if spreads:
            cells.append(f"+- {_mm(spreads[row['name']])}" if row["name"] in spreads else "")
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
        cells = [f"({_mm(v)})" if i == j else _mm(v) for j, v in enumerate(values)]
        table.add_row(f"{i + 1} {name}", *cells)
    return table

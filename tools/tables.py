"""Figures for people: tables in millimetres, the same on a terminal and in a pipe."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ..solver.parameters import COMPONENTS

__all__ = ["metrics_table", "parameters_table"]

_COLUMNS = (
    ("MAE", "mean_absolute_error"),
    ("max", "max_error"),
    ("distance", "distance_error"),
)


def metrics_table(figures: Mapping[str, Any]) -> Table:
    """Return nominal and calibrated errors of every placement, and the summaries [mm]."""
    table = _table("errors in mm, nominal > calibrated")
    table.add_column("placement", overflow="fold")
    table.add_column("samples", justify="right", no_wrap=True)
    for title, _ in _COLUMNS:
        table.add_column(title, justify="right", no_wrap=True)
    for role, title in (("train", "trained on"), ("test", "held out")):
        rows = [row for row in figures["placements"] if row["role"] == role]
        for row in rows:
            table.add_row(row["name"], "+".join(map(str, row["samples"])), *_cells(row))
        summary = figures["summary"][role]
        if summary is not None:
            removed = f"{100 * summary['removed_error']:.1f} % less"
            table.add_row(f"= {title}, mean", removed, *_cells(summary), style="bold")
            table.add_section()
    return table


def _table(title: str) -> Table:
    return Table(box=SIMPLE_HEAD, title=title, title_justify="left", padding=(0, 1, 0, 0))


def _cells(row: Mapping[str, Any]) -> list[str]:
    return [
        f"{1e3 * row['nominal'][key]:.3f} > {1e3 * row['calibrated'][key]:.3f}"
        for _, key in _COLUMNS
    ]


def parameters_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return what the calibration changed, in mm and mrad; one line a joint."""
    table = _table("change of the joint origins, in mm and mrad")
    table.add_column("joint", overflow="fold")
    for component in COMPONENTS:
        table.add_column(component, justify="right", no_wrap=True)
    changes = {(row["joint"], row["component"]): row["change"] for row in rows}
    for joint in dict.fromkeys(row["joint"] for row in rows):
        cells = [
            f"{1e3 * changes[joint, c]:+.3f}" if (joint, c) in changes else "fixed"
            for c in COMPONENTS
        ]
        table.add_row(joint, *cells)
    return table

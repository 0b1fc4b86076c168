"""The errors of a calibration as a plain table in millimetres."""

from collections.abc import Sequence

from ..assessment import millimetres
from ..data import Metrics, removed_share
from ..results import PlacementErrors, Role, Summaries, Summary

HEADS = ("placement", "samples", "MAE", "max", "distance")


def error_rows(
    placements: Sequence[PlacementErrors], summaries: Summaries
) -> list[tuple[bool, list[str]]]:
    """Return the rows of the table of errors, nominal > calibrated [mm]; True marks a summary.

    Where the URDF is not the full model, a row of the full model's errors follows each.
    """
    rows: list[tuple[bool, list[str]]] = []
    parts: tuple[tuple[Role, str, Summary | None], ...] = (
        ("train", "trained on", summaries.train),
        ("test", "held out", summaries.test),
    )
    for role, title, summary in parts:
        for row in placements:
            if row.role == role:
                name = row.name if row.kind == "sockets" else f"{row.name} (true error)"
                rows += _rows(row, False, name, "+".join(map(str, row.samples)))
        if summary is not None:
            removed = f"{100 * removed_share(summary.nominal, summary.loaded):.1f} % less"
            rows += _rows(summary, True, f"= {title}", removed)
    return rows


def errors_title(placements: Sequence[PlacementErrors]) -> str:
    """Return what the table of errors shows."""
    if any(row.geometric is not None for row in placements):
        return (
            "errors in mm, nominal > calibrated.urdf; below, with joint positions corrected first"
        )
    return "errors in mm, nominal > calibrated"


def errors_text(placements: Sequence[PlacementErrors], summaries: Summaries) -> str:
    """Return the table of errors as lines of plain text."""
    rows = [list(HEADS), *(cells for _, cells in error_rows(placements, summaries))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(
            cell.rjust(width) if i else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    return "\n".join([errors_title(placements), *lines])


def _rows(
    row: PlacementErrors | Summary, summed: bool, name: str, samples: str
) -> list[tuple[bool, list[str]]]:
    pairs = zip(_figures(row.nominal), _figures(row.loaded), strict=True)
    cells = [f"{millimetres(before)} > {millimetres(after)}" for before, after in pairs]
    rows = [(summed, [name, samples, *cells])]
    if row.geometric is not None:
        full = [f"> {millimetres(value)}" for value in _figures(row.calibrated)]
        rows.append((False, ["  with corrected joints", "", *full]))
    return rows


def _figures(metrics: Metrics) -> tuple[float, float, float | None]:
    """Return the figures of the columns [m]."""
    return metrics.mean_absolute_error, metrics.max_error, metrics.distance_error

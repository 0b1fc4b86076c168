"""Errors of placements, as several verbs show them: a short table, or all figures."""

from collections.abc import Sequence

from ....errors import fixed
from ....solver import calibration, results
from ....solver.assessment import millimetres, plural, short_names
from ... import cli

MOST_ROWS = 6
"""Placements in the short table, the worst ones."""
LONGEST = 26
"""Letters of a placement's name there."""
ROLES = {"train": "trained on", "test": "held out"}


def show_errors(
    errors: "calibration.Errors", terminal: cli.Terminal, *, short: bool = False
) -> None:
    """Show the nominal and the calibrated errors of each placement, and the summaries."""
    if short:
        terminal.say_rows(short_rows(errors), aligned)
        return
    summed, rows = zip(*errors.table(), strict=True)
    bold = [number for number, sums_up in enumerate(summed) if sums_up]
    terminal.tabulate(errors.title, calibration.HEADS, rows, bold=bold, no_wrap=True)


def short_rows(errors: "calibration.Errors") -> list[list[str]]:
    """Return rows with mean errors before, by the URDF, and with corrected joints [mm].

    The heads come first. A row of a single cell tells how many placements are left out.
    """
    names = short_names([row.name for row in errors])
    two = any(row.geometric is not None for row in errors)
    heads = ["mean error, mm", "", "samples", "before", "now"]
    rows = [[*heads, "corrected joints"] if two else heads]
    worst = sorted(errors, key=lambda row: -row.loaded.mean_absolute_error)[:MOST_ROWS]
    for name, row in zip(names, errors, strict=True):
        if row in worst:
            samples = "+".join(map(str, row.samples))
            figures = _figures(row, two=two)
            rows.append([name[-LONGEST:], ROLES[row.role], samples, *figures])
    if len(errors) > MOST_ROWS:
        others = plural(len(errors) - MOST_ROWS, "placement")
        rows.append([f"  and {others} with smaller errors"])
    for role, title in ROLES.items():
        summary: results.Summary | None = getattr(errors.summary, role)
        if summary is not None:
            removed = f"{fixed(-100 * summary.removed_when_loaded, 1, '+')} %"
            rows.append(["= mean", title, removed, *_figures(summary, two=two)])
    return rows


def aligned(row: Sequence[str]) -> str:
    """Return a row of the short table as a line."""
    if len(row) == 1:
        return row[0]
    name, role, samples, *figures = row
    columns = "  ".join(f"{figure:>6}" for figure in figures)
    return f"{name:{LONGEST}} {role:10} {samples:>8}  {columns}"


def _figures(row: results.PlacementErrors | results.Summary, *, two: bool) -> list[str]:
    models = (row.before, row.loaded, row.calibrated)
    return [millimetres(model.mean_absolute_error) for model in models[: 2 + two]]

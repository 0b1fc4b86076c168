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


def show_errors(
    errors: "calibration.Errors", terminal: cli.Terminal, *, short: bool = False
) -> None:
    """Show the nominal and the calibrated errors of each placement, and the summaries."""
    if short:
        is_proven = errors.summary.left_out is not None
        rows = left_out_rows(errors) if is_proven else short_rows(errors)
        terminal.say_rows(rows, _aligned_left_out if is_proven else aligned)
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
            rows.append([name[-LONGEST:], results.ROLES[row.role], samples, *figures])
    rows += _others(len(errors))
    for role, title in results.ROLES.items():
        summary: results.Summary | None = getattr(errors.summary, role)
        if summary is not None:
            removed = _removed(summary)
            rows.append(["= mean", title, removed, *_figures(summary, two=two)])
    return rows


def left_out_rows(errors: "calibration.Errors") -> list[list[str]]:
    """Return rows with mean errors before, left out, trained on, and with corrected joints [mm].

    All but those trained on are by the fit that left the placement out.
    """
    trained = [row for row in errors if row.role == "train"]
    two = any(row.geometric is not None for row in errors)
    heads = ["mean error, mm", "samples", "before", "left out", "trained on"]
    rows = [[*heads, "corrected joints"] if two else heads]
    left_out = [errors.left_out(row.name) for row in trained]
    largest = sorted(
        (row.loaded.mean_absolute_error for row in left_out if row), reverse=True
    )
    least = largest[:MOST_ROWS][-1]
    names = short_names([row.name for row in trained])
    for name, row, proof in zip(names, trained, left_out, strict=True):
        if proof is None or proof.loaded.mean_absolute_error >= least:
            samples = "+".join(map(str, row.samples))
            cells = _beside_trained(proof, row, two=two)
            rows.append([name[-LONGEST:], samples, *cells])
    rows += _others(len(trained))
    summary = errors.summary
    assert summary.train is not None and summary.left_out is not None
    cells = _beside_trained(summary.left_out, summary.train, two=two)
    return [*rows, ["= mean", _removed(summary.left_out), *cells]]


def _beside_trained(
    left_out: "results.MetricsByModel | None",
    trained: "results.MetricsByModel",
    *,
    two: bool,
) -> list[str]:
    """Return the cells of a row: before, left out, trained on, and with corrected joints."""
    fitted = millimetres(trained.loaded.mean_absolute_error)
    if left_out is None:
        return ["-", "-", fitted, *["-"] * two]
    before, *cells = _figures(left_out, two=two)
    return [before, cells[0], fitted, *cells[1:]]


def _others(count: int) -> list[list[str]]:
    """Return the row that tells how many of so many placements are not shown."""
    if count <= MOST_ROWS:
        return []
    return [[f"  and {plural(count - MOST_ROWS, 'placement')} with smaller errors"]]


def _removed(summary: "results.Summary") -> str:
    return f"{fixed(-100 * summary.removed_when_loaded, 1, '+')} %"


def aligned(row: Sequence[str]) -> str:
    """Return a row of the short table as a line."""
    if len(row) == 1:
        return row[0]
    name, role, samples, *figures = row
    columns = "  ".join(f"{figure:>6}" for figure in figures)
    return f"{name:{LONGEST}} {role:10} {samples:>8}  {columns}"


def _aligned_left_out(row: Sequence[str]) -> str:
    """Return a row of the table of what was left out as a line."""
    if len(row) == 1:
        return row[0]
    name, samples, before, left_out, trained, *corrected = row
    cells = [f"{before:>6}", f"{left_out:>8}", f"{trained:>10}"]
    cells += [f"{figure:>6}" for figure in corrected]
    return f"{name:{LONGEST}} {samples:>8}  {'  '.join(cells)}"


def _figures(row: "results.MetricsByModel", *, two: bool) -> list[str]:
    models = (row.before, row.loaded, row.calibrated)
    return [millimetres(model.mean_absolute_error) for model in models[: 2 + two]]

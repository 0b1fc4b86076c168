"""The report in short, for the terminal: the verdict, the placements, the answers."""

from collections.abc import Iterable

import numpy as np
from rich.console import Console
from rich.text import Text

from ...solver.assessment import RESOLUTION, Limits, Verdict, mm
from ...solver.results import ROLES
from ..cli import FittingTable
from .figures import ReportDocument, Step

BARS = 24
"""Of a placement's errors, each the largest of a stretch, at most."""
_BARS = "▁▂▃▄▅▆▇█"
_STYLES = {
    "pass": "green",
    "not enough": "bold yellow",
    "fail": "bold red",
    "yes": "green",
    "no": "red",
    "mostly": "yellow",
}


def show(console: Console, report: ReportDocument) -> None:
    """Print the report in short."""
    show_answer(console, report.verdict)
    if report.error_parts:
        console.print(Text(report.error_parts.text))
    show_limits(console, report.verdict, report.limits, report.todo)
    console.print(_placements(console, report))
    answers = report.answers
    for title, text in (
        ("Use", answers.use.text),
        ("URDF", answers.use.alone),
        ("Next", answers.next.text),
        ("Data", answers.data.text),
    ):
        if text:
            console.print(Text.assemble((f"{title}: ", "bold"), text))
    for check in report.checks or ():
        if check.level != "ok":
            console.print(Text(f"  {check.level} {check}"))


def show_answer(console: Console, verdict: Verdict) -> None:
    """Print what the errors were and are, and whether to load the model."""
    colours = {"pass": "green", "fail": "red", "incomplete": "yellow"}
    by_lines = not console.is_terminal  # a program that reads lines finds each whole
    for words in verdict.answer:
        console.print(Text(words), soft_wrap=by_lines)
    stamp = verdict.stamp
    title = Text.assemble(
        "Verdict: ",
        (stamp, f"bold {colours[verdict.colour]}"),
        verdict.title[len(stamp) :],
    )
    console.print(title, soft_wrap=by_lines)


def show_limits(
    console: Console, verdict: Verdict, limits: Limits, todo: Iterable[Step]
) -> None:
    """Print the verdict limit by limit, what else bears on it, and the next step."""
    lengths = ["found", "at most"]
    if any(row.full is not None for row in verdict.limits):
        lengths = ["URDF alone", "at most", "with corrected joints"]
    rows: list[list[str | Text]] = []
    for row in verdict.limits:
        status = Text(row.status, _STYLES.get(row.status, "yellow"))
        values = (row.found, row.limit, row.full)[: len(lengths)]
        cells = ["-" if value is None else mm(value, 3) for value in values]
        rows.append([row.title, status, *cells])
    if rows:
        heads = ["limit on", "", *lengths]
        console.print(FittingTable("", heads, rows, left_columns=(0, 1)))
    for row in verdict.reasons:
        console.print(Text(f"{row.status.capitalize()}: {row.text}."))
    show_steps(console, todo)
    if limits.repeatability is not None:
        words = f"{1e3 * limits.repeatability:g} mm ({limits.repeatability_source})"
        if limits.repeatability < RESOLUTION:
            words += f"; limits go by the {1e3 * RESOLUTION:g} mm that a printed socket resolves"
        console.print(Text(f"The arm's repeatability: {words}."))


def show_steps(console: Console, todo: Iterable[Step]) -> None:
    """Print what to do next."""
    for step in todo:
        console.print(Text(f"Do this next: {step.text}:"))
        console.print(Text(f"   {step.command}"), soft_wrap=True)
        console.print(Text(f"   Expected: {step.expected}."))


def _placements(console: Console, report: ReportDocument) -> FittingTable:
    curves = console.is_terminal and (console.encoding or "").lower().startswith("utf")
    asked = report.task is not None
    within = "serves tasks that allow"
    if asked:
        within = f"within {1e3 * report.tolerance:g} mm?"
    heads = ["placement", "role", "MAE, mm", "95 %", "largest", within]
    heads += ["errors as recorded"] if curves else []
    top = max(1e-9, *(row.error("geometric") for row in report.samples))
    rows: list[list[str | Text]] = []
    pairs = zip(report.placements, report.answers.use.rows, strict=True)
    for i, (row, use) in enumerate(pairs):
        before = row.before.mean_absolute_error
        after = row.loaded.mean_absolute_error
        serves = use.answer if asked or use.least is None else mm(use.least)
        cells: list[str | Text] = [
            use.name,
            ROLES[row.role],
            f"{1e3 * before:.2f} -> {1e3 * after:.3f}",
            f"{1e3 * row.quantiles.loaded.p95:.2f}",
            f"{1e3 * row.quantiles.loaded.max:.2f}",
            Text(serves, _STYLES.get(serves, "")),
        ]
        samples = (s for s in report.samples if s.placement == i)
        errors = [sample.error("geometric") for sample in samples]
        parts = np.array_split(errors, min(BARS, len(errors)))
        levels = (int(len(_BARS) * max(part) / top) for part in parts)
        bars = "".join(_BARS[min(level, len(_BARS) - 1)] for level in levels)
        rows.append([*cells, *([bars] if curves else [])])
    return FittingTable("", heads, rows, left_columns=(0, 1, 5, 6))

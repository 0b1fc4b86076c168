"""Plots of samples, flat, in space and in order, and of the use: by placement, on the table."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from ....solver.assessment import SampleErrors, area, nice_above
from ....solver.results import ModelName, Role
from ..figures import FAR, Answer, ReportDocument, text
from .axis import MM, Axis
from .figure import (
    FROM_ABOVE,
    LOADED,
    Panel,
    Plot,
    from_above,
    named_rows,
    plot,
    to_scale,
)


def _lengths(
    report: ReportDocument, model: ModelName, role: Role | None = None
) -> np.ndarray:
    """Return the error of each sample [m], of one role or of all, shape (N,)."""
    roles = [row.role for row in report.placements]
    rows = [row for row in report.samples if role in (None, roles[row.placement])]
    return np.array([row.error(model) for row in rows])


WINDOW = 7
"""Samples in a running centre."""
FINE = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)
"""Round numbers of the axes, to be filled well."""


def errors_in_3d(report: ReportDocument) -> Plot:
    """Every sample round its socket, nominal and calibrated side by side, to one scale."""
    largest = [float(_lengths(report, m).max(initial=0.0)) for m, _ in LOADED]
    half = nice_above(max(*largest, 1e-6), FINE)
    placements = [(i, row.name) for i, row in enumerate(report.placements)]
    return plot(
        "errors-3d",
        layout="scenes",
        scene="errors",
        controls={"placements": placements, "half": half},
        report=report,
        largest=largest,
    )


def errors_in_2d(report: ReportDocument) -> Plot:
    """Every sample round its socket, seen along two axes."""
    largest = [float(_lengths(report, model).max(initial=1e-9)) for model, _ in LOADED]
    large, small = (nice_above(length, FINE) for length in largest)
    limit = report.limits.mean_absolute_error.value
    if limit and limit < 1.4 * small:  # it is drawn, all of it
        small = max(small, nice_above(limit, FINE))
    large = max(large, small)
    times = float(f"{large / small:.2g}")
    views: tuple[tuple[ModelName, float, str], ...] = (
        ("nominal", large, "nominal"),
        ("geometric", large, "calibrated"),
        ("geometric", small, f"calibrated x {times:g}"),
    )
    sides = (("xy", "from above"), ("xz", "from the side"))
    panels = [
        _plane(report, model, axes, half, f"{side}: {title}")
        for (axes, side), (model, half, title) in product(sides, views)
    ]
    return plot(
        "errors-2d",
        *panels,
        layout="thirds",
        report=report,
        times=times,
        half=MM * small,
    )


def _plane(
    report: ReportDocument, model: ModelName, axes: str, half: float, title: str
) -> Panel:
    """Return the samples along two axes, up to half the panel's width [m]."""
    scales = [Axis(-half, half, f"{axis}, mm", MM, ticks=(0.0, half)) for axis in axes]
    panel = Panel(title, *scales, width=248, height=276, margin=44).grid()
    mark = dict(LOADED)[model]
    i, j = map("xyz".index, axes)
    for row in report.samples:
        deviation = row.of(model)
        role = report.placements[row.placement].role
        panel.dot(deviation[i], deviation[j], f"{mark} {role}", size=2)
    limit = report.limits.mean_absolute_error.value
    if limit and limit <= half:
        panel.dot(0, 0, "threshold", size=panel.x(limit) - panel.x(0))
    return panel


def order(report: ReportDocument) -> Plot:
    """The calibrated error of each sample in the order of recording, and the running centre."""
    means = [row.calibrated.mean_absolute_error for row in report.placements]
    errors = _lengths(report, "calibrated")
    top = 1.08 * max(float(errors.max(initial=1e-6)), FAR * max(means))
    mean = np.array([means[row.placement] for row in report.samples])
    uses = enumerate(report.answers.use.rows)
    return plot(
        "order",
        *(_order_panel(report, i, use.name, top) for i, use in uses),
        report=report,
        beyond=int(np.sum(errors / np.maximum(mean, 1e-12) > FAR)),
        far=FAR,
        window=WINDOW,
        weighted=any(map(_doubted, report.samples)),
    )


def _doubted(sample: SampleErrors) -> bool:
    """Return True where the fit gave a sample less than half of its weight."""
    return sample.weight is not None and sample.weight < 0.5


def _order_panel(report: ReportDocument, i: int, name: str, top: float) -> Panel:
    place = report.placements[i]
    rows = [row for row in report.samples if row.placement == i]
    axes = Axis(0, len(rows) + 1, ticks=()), Axis(0, top, "mm", MM)
    panel = Panel(name, *axes, height=170).grid()
    panel.threshold(f"{FAR:g} x mean", y=FAR * place.calibrated.mean_absolute_error)
    first = 0
    for socket in dict.fromkeys(row.socket for row in rows):
        deviations = np.array([row.calibrated for row in rows if row.socket == socket])
        if first:
            panel.rule("divide", x=first + 0.5)
        panel.text(
            panel.x(first + 0.5) + 6, panel.bottom + 15, f"socket {socket}", "tick"
        )
        panel.line(enumerate(_running_centre(deviations), first + 1), "running")
        first += len(deviations)
    for k, row in enumerate(rows, 1):
        error = row.error()
        mark = "flagged" if _doubted(row) else f"calibrated {place.role}"
        panel.dot(k, error, mark, f"{row.where}: {MM * error:.3f} mm")
    return panel


def _running_centre(deviations: np.ndarray) -> list[float]:
    """Return the length of the mean deviation of the samples round each one."""
    half = WINDOW // 2
    windows = [
        deviations[max(0, k - half) : k + half + 1] for k in range(len(deviations))
    ]
    means = [window.mean(axis=0) for window in windows]
    return np.linalg.norm(means, axis=1).tolist()


HALF = 0.16
"""Margin of the map [m]."""


def errors_by_placement(report: ReportDocument) -> Plot:
    """Mean absolute error before and after at each placement, and the limit."""
    rows = report.placements
    names = [row.name for row in report.answers.use.rows]
    roles = [row.role for row in rows]
    before = [row.before.mean_absolute_error for row in rows]
    after = [row.loaded.mean_absolute_error for row in rows]
    x = Axis.logarithmic([*before, *after], "mean absolute error, mm", MM)
    panel = named_rows("error at each placement", names, x, pitch=28)
    panel.bars(before, after, "link")
    for (_, mark), values in zip(LOADED, (before, after), strict=True):
        panel.dots(values, [f"{mark} {role}" for role in roles], mark)
    limit = report.limits.mean_absolute_error.value
    panel.threshold("limit {} mm", x=limit)
    role = report.summary.judged[0]
    columns = zip(after, before, names, roles, strict=True)
    return plot(
        "errors-by-placement",
        panel,
        layout="half",
        report=report,
        judged=[row for row in columns if row[-1] == role],
    )


def table_map(report: ReportDocument) -> Plot:
    """The placements as the robot sees them from above, coloured by the answer for the task."""
    rows = report.placements
    place = report.answers.next.place
    seen = from_above([(0, 0, 0), place, *(row.position for row in rows)])
    panel = to_scale("", seen, FROM_ABOVE, room=HALF)
    (x, y), following, *others = seen.tolist()
    panel.dot(x, y, "base", "the robot's base", size=9)
    panel.text(panel.x(x) + 13, panel.y(y) + 4, "robot", "tick")
    x, y = following
    panel.dot(x, y, "next", f"record next: {area(place)}", size=9)
    panel.text(panel.x(x), panel.y(y) + 22, "next", "tick middle")
    uses = report.answers.use.rows
    asked = report.task is not None
    for i, (row, use) in enumerate(zip(rows, uses, strict=True)):
        right, ahead = others[i]
        x = panel.x(right)
        y = panel.y(ahead)
        word = use.answer.split(" ")[0] if asked or use.least is None else "unasked"
        mark = {"class_": f"answer {word}", "data_placement": i}
        panel.add(
            "circle", f"{use.name}: {area(row.position)}", cx=x, cy=y, r=10, **mark
        )
        panel.text(x, y + 4, str(i + 1), "number middle light")
    allowed = f"{MM * report.tolerance:g}" if asked else None
    return plot(
        "table-map",
        panel,
        layout="beside",
        controls={"uses": uses},
        text=map_sentence(report, [use.answer for use in uses], allowed),
        asked=asked,
    )


def map_sentence(
    report: ReportDocument, answers: Sequence[Answer], allowed: str | None
) -> str:
    """Return at how many places the task can be done, with the error that it allows in words.

    Where nobody said what it allows, the largest error stands in its place.
    """
    heights = [row.position[2] for row in report.placements]
    role = report.summary.judged[0]
    return text(
        "captions.txt.j2",
        "map_sentence",
        role=role,
        total=sum(row.role == role for row in report.placements),
        allowed=allowed,
        proven=answers.count("yes"),
        largest=max(
            (use.least for use in report.answers.use.rows if use.least), default=0.0
        ),
        low=min(heights),
        high=max(heights),
    )


def shares(report: ReportDocument) -> Plot:
    """Share of the samples within an error, and the task's tolerance."""
    role, _ = report.summary.judged
    words = "held-out" if role == "test" else "trained-on"
    errors = {mark: np.sort(_lengths(report, model, role)) for model, mark in LOADED}
    x = Axis.logarithmic(
        [report.task, *np.concatenate(list(errors.values()))], "error, mm", MM
    )
    panel = Panel(
        f"{words} samples within an error", x, Axis(0, 100, "% of samples")
    ).grid()
    for mark, lengths in errors.items():
        percents = np.linspace(0, 100, len(lengths) + 1)
        ends = [x.low, *lengths, x.high]
        panel.line(np.column_stack([ends, [*percents, 100]]).tolist(), f"curve {mark}")
    panel.threshold("{} mm", x=report.task)
    return plot("shares", panel, layout="half", report=report, words=words)

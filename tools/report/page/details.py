"""The report's last part: parameters, uncertainty, samples to look at, and provenance."""

from ....solver.assessment import mm, plural
from ....solver.results import Coefficient, ParameterValue
from ..figures import ReportDocument
from ..plots import shown_unit
from .html import Cell, Element, Node, figure, table, tag


def details(report: ReportDocument) -> Element:
    """Return the tables for those who want to know exactly."""
    return tag(
        "section",
        tag("h2", "In detail"),
        _worst(report),
        _parameters(report),
        _uncertainty(report),
        _groups(report),
        _warnings(report),
        _provenance(report),
        id="details",
    )


def _worst(report: ReportDocument) -> Element:
    rows: list[list[Cell]] = []
    for i, row in enumerate(report.answers.data.worst):
        path = f"answers.data.worst.{i}"
        cells: list[Cell] = [
            row.where,
            [figure(report, f"{path}.error"), " mm"],
            [figure(report, f"{path}.ratio", scale=1, digits=1), " x"],
        ]
        if row.weight is not None:
            cells.append(figure(report, f"{path}.weight", scale=1, digits=2))
        rows.append(cells)
    heads = ["file and line", "from its socket", "its placement's mean", "weight in the fit"]
    width = max(map(len, rows))
    rows = [row + [""] * (width - len(row)) for row in rows]
    return tag("div", tag("h3", "The farthest samples"), table(heads[:width], rows))


def _parameters(report: ReportDocument) -> Element:
    rows = [
        _parameter_row(report, f"parameters.{i}", row, ("nominal", "calibrated", "change"))
        for i, row in enumerate(report.parameters)
    ]
    rows += [
        _parameter_row(report, f"coefficients.{i}", row, (None, "value", "value"))
        for i, row in enumerate(report.coefficients or ())
    ]
    heads = ["parameter", "nominal", "calibrated", "change", "standard deviation", "unit"]
    return tag(
        "details",
        tag("summary", f"All {len(rows)} parameters{_parts(report)}"),
        table(heads, rows, "numbers"),
    )


def _parts(report: ReportDocument) -> str:
    """Return how many parameters are what, where they are of several kinds."""
    others = report.coefficients or ()
    off = sum(not (row.value or row.standard_deviation) for row in others)
    words = f": {len(report.parameters)} of joint origins and ball, {len(others)} of the extensions"
    return f"{words}, {off} of them switched off" if others else ""


def _parameter_row(
    report: ReportDocument,
    path: str,
    row: ParameterValue | Coefficient,
    keys: tuple[str | None, str, str],
) -> list[Cell]:
    """Return a parameter's cells; ``keys`` name its nominal and calibrated value and the change."""
    factor, unit = shown_unit(row.unit)
    numbers: list[Cell] = [
        figure(report, f"{path}.{key}", scale=factor, digits=4, sign=sign) if key else "0"
        for key, sign in zip(keys, ("", "", "+"), strict=True)
    ]
    deviation: Cell = "\N{EN DASH}"
    if row.standard_deviation is not None:
        deviation = figure(report, f"{path}.standard_deviation", scale=factor, digits=4)
    return [row.name, *numbers, deviation, unit]


def _uncertainty(report: ReportDocument) -> Element | None:
    uncertainty = report.uncertainty
    if uncertainty is None:
        return None
    index = figure(report, "uncertainty.observability_index", scale=1, digits=6)
    lines = [
        tag(
            "p",
            "Predicted error of distances in the workspace, one standard deviation: median ",
            figure(report, "uncertainty.distance_deviation.median"),
            " mm, worst ",
            figure(report, "uncertainty.distance_deviation.worst"),
            " mm.",
        ),
        tag("p", "Observability index O1: ", index, "."),
    ]
    if uncertainty.weak_directions:
        texts = [tag("li", row.text) for row in uncertainty.weak_directions]
        lines.append(tag("p", "What the data hardly settle:"))
        lines.append(tag("ul", texts, class_="many"))
    if uncertainty.correlations:
        rows: list[list[Cell]] = [
            [
                row.a,
                row.b,
                figure(report, f"uncertainty.correlations.{i}.value", scale=1, digits=3, sign="+"),
            ]
            for i, row in enumerate(uncertainty.correlations)
        ]
        lines.append(
            tag(
                "details",
                tag("summary", plural(len(rows), "strong correlation")),
                table(["parameter", "and parameter", "correlation"], rows),
            )
        )
    return tag("div", tag("h3", "How sure the model is"), lines)


def _groups(report: ReportDocument) -> Element | None:
    if not report.groups:
        return None
    cells: list[list[Cell]] = []
    for i, row in enumerate(report.groups):
        factor, unit = shown_unit(row.unit)
        path = f"groups.{i}"
        cells.append(
            [
                row.name.replace("_", " "),
                figure(report, f"{path}.count", scale=1, digits=0),
                figure(report, f"{path}.effective", scale=1, digits=1),
                [figure(report, f"{path}.width", scale=factor, digits=4), f" {unit}"],
                "on" if row.active else "off",
            ]
        )
    words: list[Node] = []
    if report.noise is not None:
        words = [
            "Noise of a ball position: ",
            figure(report, "noise.space", digits=3),
            " mm in space, ",
            figure(report, "noise.joint", digits=3),
            " mrad in each joint.",
        ]
    heads = ["group", "parameters", "settled by the data", "width of the prior", ""]
    choices = tag("ul", [tag("li", line) for line in report.choices or ()])
    return tag("div", tag("h3", "Groups and noise"), table(heads, cells), tag("p", words), choices)


def _warnings(report: ReportDocument) -> Element | None:
    if not report.warnings:
        return None
    lines = [tag("li", words) for words in report.warnings]
    return tag("div", tag("h3", "Warnings of the run"), tag("ul", lines))


def _provenance(report: ReportDocument) -> Element:
    made = report.provenance
    settings = [
        f"{key} {value}"
        for key, value in made.settings.items()
        if value not in (None, [], "", False)
    ]
    steps = plural(report.iterations, "iteration")
    versions = [f"{name} {number}" for name, number in made.versions.items()]
    rows = [
        ["made", made.created],
        ["model", f"{report.robot}, SHA-256 {made.model_sha256}"],
        ["method", f"{report.method}, {report.optimizer}, {steps}"],
        ["settings", ", ".join(settings)],
        ["versions", ", ".join(versions)],
        ["task", f"an error of {mm(report.tolerance)} allowed"],
    ]
    data = [[file, tag("code", digest)] for file, digest in made.data_sha256.items()]
    return tag(
        "div",
        tag("h3", "Where it comes from"),
        table(["", ""], rows, "plain"),
        tag("p", "The command that makes it again:"),
        tag("pre", report.command),
        tag("details", tag("summary", f"{len(data)} data files"), table(["file", "SHA-256"], data)),
    )

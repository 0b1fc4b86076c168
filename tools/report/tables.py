"""The report's last part: parameters, uncertainty, samples to look at, and provenance."""

from collections.abc import Mapping, Sequence
from typing import Any

from .cells import figure, table
from .markup import Element, tag
from .plots_model import shown_unit
from .words import mm, plural

__all__ = ["details"]

Figures = Mapping[str, Any]


def details(figures: Figures) -> Element:
    """Return the tables for those who want to know exactly."""
    return tag(
        "section",
        tag("h2", "In detail"),
        _worst(figures),
        _parameters(figures),
        _uncertainty(figures),
        _groups(figures),
        _warnings(figures),
        _provenance(figures),
        id="details",
    )


def _worst(figures: Figures) -> Element:
    rows: list[list[Any]] = []
    for i, row in enumerate(figures["answers"]["data"]["worst"]):
        path = f"answers.data.worst.{i}"
        cells = [
            row["where"],
            [figure(figures, f"{path}.error"), " mm"],
            [figure(figures, f"{path}.ratio", scale=1, digits=1), " x"],
        ]
        if row["weight"] is not None:
            cells.append(figure(figures, f"{path}.weight", scale=1, digits=2))
        rows.append(cells)
    heads = ["file and line", "from its socket", "its placement's mean", "weight in the fit"]
    width = max(map(len, rows))
    rows = [row + [""] * (width - len(row)) for row in rows]
    return tag("div", tag("h3", "The farthest samples"), table(heads[:width], rows))


def _parameters(figures: Figures) -> Element:
    rows = [
        _parameter_row(figures, f"parameters.{i}", row, ("nominal", "calibrated", "change"))
        for i, row in enumerate(figures["parameters"])
    ]
    rows += [
        _parameter_row(figures, f"coefficients.{i}", row, (None, "value", "value"))
        for i, row in enumerate(figures.get("coefficients", []))
    ]
    heads = ["parameter", "nominal", "calibrated", "change", "standard deviation", "unit"]
    return tag(
        "details",
        tag("summary", f"All {len(rows)} parameters"),
        table(heads, rows, "numbers"),
    )


def _parameter_row(
    figures: Figures, path: str, row: Figures, keys: Sequence[str | None]
) -> list[Any]:
    factor, unit = shown_unit(row["unit"])
    numbers = [
        figure(figures, f"{path}.{key}", scale=factor, digits=4, sign=sign) if key else "0"
        for key, sign in zip(keys, ("", "", "+"), strict=True)
    ]
    deviation: Any = "\N{EN DASH}"
    if row.get("standard_deviation") is not None:
        deviation = figure(figures, f"{path}.standard_deviation", scale=factor, digits=4)
    return [row["name"], *numbers, deviation, unit]


def _uncertainty(figures: Figures) -> Element | None:
    found = figures.get("uncertainty")
    if not found:
        return None
    lines: list[Any] = []
    deviation = found.get("distance_deviation")
    if deviation:
        lines.append(
            tag(
                "p",
                "Predicted error of distances in the workspace, one standard deviation: median ",
                figure(figures, "uncertainty.distance_deviation.median"),
                " mm, worst ",
                figure(figures, "uncertainty.distance_deviation.worst"),
                " mm.",
            )
        )
    if found.get("observability_index") is not None:
        index = figure(figures, "uncertainty.observability_index", scale=1, digits=6)
        lines.append(tag("p", "Observability index O1: ", index, "."))
    weak: list[Any] = found.get("weak_directions") or []
    if weak:
        lines.append(tag("p", "What the data hardly settle:"))
        lines.append(tag("ul", [tag("li", row["text"]) for row in weak], class_="many"))
    pairs: list[Any] = found.get("correlations") or []
    if pairs:
        rows: list[list[Any]] = [
            [
                row["a"],
                row["b"],
                figure(figures, f"uncertainty.correlations.{i}.value", scale=1, digits=3, sign="+"),
            ]
            for i, row in enumerate(pairs)
        ]
        lines.append(
            tag(
                "details",
                tag("summary", plural(len(rows), "strong correlation")),
                table(["parameter", "and parameter", "correlation"], rows),
            )
        )
    return tag("div", tag("h3", "How sure the model is"), lines)


def _groups(figures: Figures) -> Element | None:
    rows = figures.get("groups")
    if not rows:
        return None
    cells: list[list[Any]] = []
    for i, row in enumerate(rows):
        factor, unit = shown_unit(row["unit"])
        path = f"groups.{i}"
        cells.append(
            [
                row["name"].replace("_", " "),
                figure(figures, f"{path}.count", scale=1, digits=0),
                figure(figures, f"{path}.effective", scale=1, digits=1),
                [figure(figures, f"{path}.width", scale=factor, digits=4), f" {unit}"],
                "on" if row["active"] else "off",
            ]
        )
    noise = figures.get("noise")
    words: list[Any] = []
    if noise:
        words = [
            "Noise of a ball position: ",
            figure(figures, "noise.space", digits=3),
            " mm in space, ",
            figure(figures, "noise.joint", digits=3),
            " mrad in each joint.",
        ]
    heads = ["group", "parameters", "settled by the data", "width of the prior", ""]
    choices = tag("ul", [tag("li", line) for line in figures.get("choices", [])])
    return tag("div", tag("h3", "Groups and noise"), table(heads, cells), tag("p", words), choices)


def _warnings(figures: Figures) -> Element | None:
    lines = figures["warnings"]
    if not lines:
        return None
    return tag("div", tag("h3", "Warnings of the run"), tag("ul", [tag("li", w) for w in lines]))


def _provenance(figures: Figures) -> Element:
    found = figures["provenance"]
    settings = [
        f"{key} {value}"
        for key, value in found["settings"].items()
        if value not in (None, [], "", False)
    ]
    steps = plural(int(figures["iterations"]), "iteration")
    versions = [f"{name} {number}" for name, number in found["versions"].items()]
    rows: list[list[Any]] = [
        ["made", str(found.get("created", ""))],
        ["model", f"{figures['robot']}, SHA-256 {found['model_sha256']}"],
        ["method", f"{figures['method']}, {figures['optimizer']}, {steps}"],
        ["settings", ", ".join(settings)],
        ["versions", ", ".join(versions)],
        ["task", f"an error of {mm(figures['tolerance'])} allowed"],
    ]
    data: list[list[Any]] = [
        [file, tag("code", digest)] for file, digest in found["data_sha256"].items()
    ]
    return tag(
        "div",
        tag("h3", "Where it comes from"),
        table(["", ""], rows, "plain"),
        tag("p", "The command that makes it again:"),
        tag("pre", figures["command"]),
        tag("details", tag("summary", f"{len(data)} data files"), table(["file", "SHA-256"], data)),
    )

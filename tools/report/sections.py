"""The top of the report: the verdict, before and after, and the answers to a user's questions."""

from collections.abc import Mapping
from typing import Any

from .markup import Element, tag
from .words import mm, plural, short_names

__all__ = [
    "answers",
    "figure",
    "headline",
    "limits_table",
    "placements_table",
    "table",
    "verdict_box",
]

Figures = Mapping[str, Any]
SIGNS = {"pass": "\N{CHECK MARK}", "fail": "\N{MULTIPLICATION X}"}


def figure(
    figures: Any, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Element:
    """Return a number of the report, marked with where it stands in ``report.json``.

    Args:
        figures: The report's figures.
        path: Keys and indices with dots between them.
        scale: From SI to what is shown.
        digits: Behind the point.
        sign: ``+`` to show it always.
    """
    value: Any = figures
    for key in path.split("."):
        value = value[int(key)] if isinstance(value, list) else value[key]
    text = "\N{EN DASH}" if value is None else f"{scale * value:{sign}.{digits}f}"
    return tag(
        "span", text, data_figure=path, data_scale=f"{scale:g}", data_digits=digits, class_="figure"
    )


def table(heads: list[str], rows: list[list[Any]], class_: str = "") -> Element:
    """Return a table; a cell is a text, an element, or a list of them."""
    return tag(
        "div",
        tag(
            "table",
            tag("thead", tag("tr", [tag("th", head, scope="col") for head in heads])),
            tag("tbody", [tag("tr", [tag("td", _nodes(cell)) for cell in row]) for row in rows]),
            class_=class_ or None,
        ),
        class_="scroll",
    )


def _nodes(cell: Any) -> list[Any]:
    return cell if isinstance(cell, list) else [cell]


def headline(figures: Figures) -> Element:
    """Return the report's title."""
    created = str(figures["provenance"].get("created", ""))[:10]
    return tag(
        "header",
        tag("p", "Calibration report", class_="kicker"),
        tag("h1", figures["robot_name"]),
        tag("p", f"method {figures['method']}, {created}", class_="muted"),
    )


def verdict_box(figures: Figures) -> Element:
    """Return the verdict, and the error before and after in large figures."""
    found = figures["verdict"]
    role = "test" if figures["summary"]["test"] else "train"
    return tag(
        "section",
        tag(
            "div",
            tag("p", found["title"], class_="stamp"),
            tag("p", found["text"]),
            class_=f"verdict {found['status']}",
            id="verdict",
        ),
        tag(
            "div",
            _large(figures, role, "mean_absolute_error", "mean absolute error"),
            _large(figures, role, "distance_error", "socket distance error"),
            tag("p", _rests_on(figures), class_="rests"),
            class_="large",
        ),
        class_="top",
    )


def _large(figures: Figures, role: str, key: str, words: str) -> Element:
    start = f"summary.{role}"
    return tag(
        "div",
        tag("p", words, class_="kicker"),
        tag(
            "p",
            tag("span", figure(figures, f"{start}.nominal.{key}", digits=2), class_="before"),
            tag("span", "\N{RIGHTWARDS ARROW}", class_="arrow"),
            tag("span", figure(figures, f"{start}.calibrated.{key}", digits=2), class_="after"),
            tag("span", " mm", class_="unit"),
            class_="pair",
        ),
    )


def _rests_on(figures: Figures) -> list[Any]:
    """Return what was trained on, what was held out, and the fair baseline."""
    summary = figures["summary"]
    counts = {
        role: f"{plural(found['placements'], 'placement')} ({plural(found['samples'], 'sample')})"
        for role, found in summary.items()
        if found
    }
    role = "test" if summary["test"] else "train"
    held_out = f"held out {counts['test']}" if summary["test"] else "NOTHING WAS HELD OUT"
    words: list[Any] = [
        f"Trained on {counts.get('train', 'placements not in the file')}, {held_out}. Removed: ",
        figure(figures, f"summary.{role}.removed_error", scale=100, digits=1),
        " % of the error. ",
    ]
    if "ball_refitted" in summary[role]:
        path = f"summary.{role}.ball_refitted.mean_absolute_error"
        words += ["With only the ball's place refitted: ", figure(figures, path), " mm."]
    return words


def limits_table(figures: Figures) -> Element:
    """Return each limit: what was found, what is allowed, and where that comes from."""
    rows: list[list[Any]] = []
    for i, row in enumerate(figures["verdict"]["limits"]):
        status = tag(
            "span",
            f"{SIGNS.get(row['status'], '?')} {row['status']}",
            class_=f"badge {row['status'].split(' ')[0]}",
        )
        if row["limit"] is None:
            found: Any = row["text"]
            allowed: Any = "\N{EN DASH}"
        else:
            path = f"verdict.limits.{i}"
            found = [figure(figures, f"{path}.found"), " mm"] if row["found"] is not None else row["text"]
            allowed = [figure(figures, f"{path}.limit"), " mm"]
        rows.append([status, row["title"], found, allowed, row["source"]])
    heads = ["", "limit on", "found", "at most", "where the limit comes from"]
    source = figures["limits"]["repeatability_source"]
    return tag(
        "section",
        tag("h2", "Verdict, limit by limit"),
        table(heads, rows, "limits"),
        tag("p", f"Repeatability: {source}.", class_="muted"),
        id="limits",
    )


def answers(figures: Figures, table_map: Element) -> Element:
    """Return the three questions that a user has, and their answers."""
    told = figures["answers"]
    tolerance = tag(
        "input",
        type="number",
        min="0.01",
        step="0.05",
        value=f"{1e3 * figures['tolerance']:g}",
        data_control="tolerance",
        aria_label="error that the task allows, in mm",
    )
    return tag(
        "section",
        tag("h2", "Three questions"),
        tag(
            "div",
            tag(
                "article",
                tag("h3", "May I use this arm for my task?"),
                tag("label", "My task allows an error of ", tolerance, " mm.", class_="ask"),
                tag("p", told["use"]["text"], id="use-text", class_="answer-text"),
                tag("p", told["use"]["between"]),
                tag("p", "What the ball cannot tell:"),
                tag("ul", [tag("li", line) for line in told["use"]["cannot_see"]]),
            ),
            tag(
                "article",
                tag("h3", "Which placement next?"),
                tag("p", told["next"]["text"], id="next-text"),
                tag("h3", "Is my data all right?"),
                tag("p", told["data"]["text"], id="data-text"),
                _checks(figures),
            ),
            class_="columns",
        ),
        table_map,
        id="answers",
    )


def _checks(figures: Figures) -> Element | None:
    checks = [check for check in figures.get("checks") or [] if check["level"] != "ok"]
    if not checks:
        return None
    return tag(
        "ul",
        [
            tag(
                "li",
                tag("strong", f"{check['level']} "),
                f"{check.get('where', '')}: {check['text']} {check.get('advice') or ''}",
                class_=check["level"],
            )
            for check in checks
        ],
        class_="checks",
    )


def placements_table(figures: Figures) -> Element:
    """Return the errors at every placement, and whether the task can be done there."""
    names = short_names([row["name"] for row in figures["placements"]])
    rows: list[list[Any]] = []
    for i, row in enumerate(figures["placements"]):
        path = f"placements.{i}"
        told = figures["answers"]["use"]["rows"][i]
        rows.append(
            [
                names[i],
                "held out" if row["role"] == "test" else "trained on",
                told["where"],
                "+".join(map(str, row["samples"])),
                _pair(figures, path, "mean_absolute_error"),
                _pair(figures, path, "max_error"),
                [figure(figures, f"{path}.quantiles.calibrated.p95")],
                _pair(figures, path, "distance_error", "+"),
                [
                    tag(
                        "span",
                        figure(figures, f"{path}.within_tolerance", scale=100, digits=0),
                        " %",
                        data_within=i,
                    )
                ],
                tag(
                    "span",
                    told["answer"],
                    class_=f"badge {told['answer'].split(' ')[0]}",
                    data_answer=i,
                ),
            ]
        )
    tolerance = tag("span", mm(figures["tolerance"], 2), data_shown="tolerance")
    heads: list[Any] = [
        "placement",
        "role",
        "where, seen from the robot",
        "samples",
        "MAE, mm",
        "largest, mm",
        "95 % within, mm",
        "distance error, mm",
        tag("span", "within ", tolerance),
        "use it there?",
    ]
    return tag(
        "section",
        tag("h2", "Placement by placement"),
        table(heads, rows, "placements"),
        tag(
            "p",
            "Nominal \N{RIGHTWARDS ARROW} calibrated. Left and right are the robot's own: its x "
            "axis points ahead, its y axis to the left. "
            "\N{LEFT SINGLE QUOTATION MARK}Yes\N{RIGHT SINGLE QUOTATION MARK}: no sample was "
            "farther off, which with n samples still leaves a chance of up to 3 in n; "
            "\N{LEFT SINGLE QUOTATION MARK}mostly\N{RIGHT SINGLE QUOTATION MARK}: 19 of 20 were "
            "not. What was trained on proves nothing.",
            class_="muted",
        ),
        id="placements",
    )


def _pair(figures: Figures, path: str, key: str, sign: str = "") -> list[Any]:
    return [
        tag("span", figure(figures, f"{path}.nominal.{key}", digits=2, sign=sign), class_="before"),
        " \N{RIGHTWARDS ARROW} ",
        figure(figures, f"{path}.calibrated.{key}", sign=sign),
    ]

"""The top of the report: the verdict, before and after, and the answers to a user's questions."""

from collections.abc import Mapping
from typing import Any

from .cells import figure, table
from .evidence import short_where
from .markup import Element, tag
from .words import mm, plural, short_names

__all__ = [
    "answers",
    "headline",
    "limits_table",
    "placements_table",
    "verdict_box",
]

Figures = Mapping[str, Any]
SIGNS = {"pass": "\N{CHECK MARK}", "fail": "\N{MULTIPLICATION X}"}


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
        words += ["With only the ball's place refitted: ", figure(figures, path), " mm. "]
    if "geometric" in summary[role]:
        path = f"summary.{role}.geometric.mean_absolute_error"
        words += ["The exported URDF alone, without joint deflections: ", figure(figures, path)]
        words.append(" mm.")
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
        path = f"verdict.limits.{i}"
        cells = [
            "\N{EN DASH}" if row[key] is None else [figure(figures, f"{path}.{key}"), " mm"]
            for key in ("found", "limit")
        ]
        rows.append([row["title"], status, *cells, row["reason"]])
    heads = ["limit on", "", "found", "at most", "where the limit comes from, or what is missing"]
    limits = figures["limits"]
    source = limits["repeatability_source"]
    if limits["repeatability"] is not None:
        source = f"{1e3 * limits['repeatability']:g} mm ({source})"
    return tag(
        "section",
        tag("h2", "Verdict, limit by limit"),
        table(heads, rows, "limits cards"),
        tag("p", f"The arm's repeatability: {source}.", class_="muted"),
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
                tag("p", told["use"]["meaning"]),
                tag("p", told["use"]["alone"]) if told["use"]["alone"] else None,
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
    every: list[Any] = figures.get("checks") or []
    checks = [check for check in every if check["level"] != "ok"]
    if not checks:
        return None
    return tag(
        "ul",
        [
            tag(
                "li",
                tag("strong", f"{check['level']} "),
                f"{short_where(check.get('where') or '')}: {check['text']}; "
                f"{check.get('advice') or 'look at it'}",
                class_=check["level"],
            )
            for check in checks
        ],
        class_="checks",
    )


def placements_table(figures: Figures) -> Element:
    """Return the errors at every placement, and whether the task can be done there."""
    names = short_names([row["name"] for row in figures["placements"]])
    rows = [_placement_row(figures, i, name) for i, name in enumerate(names)]
    heads: list[Any] = [
        "placement",
        "where, m",
        "samples",
        "MAE, mm",
        "95 %, mm",
        "largest, mm",
        "socket distance, mm",
        "within",
        "use it there?",
    ]
    return tag(
        "section",
        tag("h2", "Placement by placement"),
        table(heads, rows, "cards"),
        tag(
            "p",
            _LEGEND,
            "Within: the share of the samples within ",
            tag("span", mm(figures["tolerance"]), data_shown="tolerance"),
            ".",
            class_="muted",
        ),
        id="placements",
    )


_LEGEND = (
    "Errors: nominal \N{RIGHTWARDS ARROW} calibrated, or calibrated alone. Where: as the robot "
    "sees it, x ahead and y to its left; placements may have been named from the other side. "
    "\u2018Yes\u2019: no sample was farther off, which with n samples still leaves a chance of up "
    "to 3 in n; \u2018mostly\u2019: 19 of 20 were not. What was trained on proves nothing. "
)


def _placement_row(figures: Figures, i: int, name: str) -> list[Any]:
    row, path = figures["placements"][i], f"placements.{i}"
    told = figures["answers"]["use"]["rows"][i]
    role = "held out" if row["role"] == "test" else "trained on"
    share = figure(figures, f"{path}.within_tolerance", scale=100, digits=0)
    badge = tag(
        "span", told["answer"], class_=f"badge {told['answer'].split(' ')[0]}", data_answer=i
    )
    return [
        tag("span", f"{i + 1} {name}", tag("small", role), class_="named"),
        told["where"],
        "+".join(map(str, row["samples"])),
        _pair(figures, path, "mean_absolute_error"),
        figure(figures, f"{path}.quantiles.calibrated.p95"),
        figure(figures, f"{path}.quantiles.calibrated.max"),
        _pair(figures, path, "distance_error", "+"),
        tag("span", share, " %", data_within=i),
        badge,
    ]


def _pair(figures: Figures, path: str, key: str, sign: str = "") -> list[Any]:
    before = figure(figures, f"{path}.nominal.{key}", digits=2, sign=sign)
    return [
        tag("span", before, class_="before"),
        " \N{RIGHTWARDS ARROW} ",
        figure(figures, f"{path}.calibrated.{key}", sign=sign),
    ]

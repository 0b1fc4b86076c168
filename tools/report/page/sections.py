"""The top of the report: the verdict, before and after, and the answers to a user's questions."""

from ....solver.assessment import LimitResult, RoleSummary, mm, plural, short_names, short_where
from ....solver.results.calibration import Role
from ..figures import ReportDocument
from .html import Cell, Element, Node, figure, table, tag

SIGNS = {"pass": "\N{CHECK MARK}", "fail": "\N{MULTIPLICATION X}"}


def headline(report: ReportDocument) -> Element:
    """Return the report's title."""
    created = report.provenance.created[:10]
    return tag(
        "header",
        tag("p", "Calibration report", class_="kicker"),
        tag("h1", report.robot_name),
        tag("p", f"method {report.method}, {created}", class_="muted"),
        tag("p", report.distance_text, class_="muted"),
    )


def verdict_box(report: ReportDocument) -> Element:
    """Return the verdict, and the error before and after in large figures."""
    verdict = report.verdict
    warned = verdict.status == "pass" and any(r.status == "warning" for r in verdict.limits)
    role, _ = report.summary.judged
    return tag(
        "section",
        tag(
            "div",
            tag("p", verdict.title, class_="stamp"),
            tag("p", verdict.text),
            class_=f"verdict {'warned' if warned else verdict.status}",
            id="verdict",
        ),
        tag(
            "div",
            _large(report, role, "mean_absolute_error", "mean absolute error"),
            _large(report, role, "distance_error", "socket distance error"),
            tag("p", _rests_on(report), class_="rests"),
            class_="large",
        ),
        class_="top",
    )


def _large(report: ReportDocument, role: Role, key: str, words: str) -> Element:
    start = f"summary.{role}"
    _, judged = report.summary.judged
    loaded = "calibrated" if judged.geometric is None else "geometric"
    return tag(
        "div",
        tag("p", words, class_="kicker"),
        tag(
            "p",
            tag("span", figure(report, f"{start}.nominal.{key}", digits=2), class_="before"),
            tag("span", "\N{RIGHTWARDS ARROW}", class_="arrow"),
            tag("span", figure(report, f"{start}.{loaded}.{key}", digits=2), class_="after"),
            tag("span", " mm", class_="unit"),
            class_="pair",
        ),
        None
        if loaded == "calibrated"
        else tag(
            "p",
            "with corrected joints: ",
            figure(report, f"{start}.calibrated.{key}", digits=2),
            " mm",
            class_="muted",
        ),
    )


def _rests_on(report: ReportDocument) -> list[Node]:
    """Return what was trained on, what was held out, and the fair baseline."""
    train, test = report.summary.train, report.summary.test
    role, judged = report.summary.judged
    trained = _counts(train) if train else "placements not in the file"
    held_out = f"held out {_counts(test)}" if test else "NOTHING WAS HELD OUT"
    words: list[Node] = [
        f"Trained on {trained}, {held_out}. Removed: ",
        figure(report, f"summary.{role}.removed_error", scale=100, digits=1),
        " % of the error",
        ". " if judged.geometric is None else " with corrected joint positions. ",
    ]
    if judged.ball_refitted is not None:
        path = f"summary.{role}.ball_refitted.mean_absolute_error"
        words += ["With only the ball's place refitted: ", figure(report, path), " mm. "]
    if judged.geometric is not None:
        words.append("Large figures: calibrated.urdf, as it is loaded. ")
    return words


def _counts(summary: RoleSummary) -> str:
    return f"{plural(summary.placements, 'placement')} ({plural(summary.samples, 'sample')})"


def todo(report: ReportDocument) -> Element | None:
    """Return what to do next; nothing where the verdict is PASS."""
    if not report.todo:
        return None
    return tag(
        "section",
        tag("h2", "Do this next"),
        tag(
            "ol",
            [
                tag(
                    "li",
                    step.text,
                    ":",
                    tag("pre", step.command),
                    tag("p", f"Expected: {step.expected}.", class_="muted"),
                )
                for step in report.todo
            ],
        ),
        id="todo",
    )


def limits_table(report: ReportDocument) -> Element:
    """Return each limit: what was found, what is allowed, and where that comes from."""
    rows: list[list[Cell]] = []
    two = any(row.full is not None for row in report.verdict.limits)

    def columns(row: LimitResult) -> list[tuple[str, float | None]]:
        lengths = [("found", row.found), ("limit", row.limit)]
        return [*lengths, ("full", row.full)] if two else lengths

    for i, row in enumerate(report.verdict.limits):
        status = tag(
            "span",
            f"{SIGNS.get(row.status, '?')} {row.status}",
            class_=f"badge {row.status.split(' ')[0]}",
        )
        path = f"verdict.limits.{i}"
        lengths: list[Cell] = [
            "\N{EN DASH}" if value is None else [figure(report, f"{path}.{key}"), " mm"]
            for key, value in columns(row)
        ]
        rows.append([row.title, status, *lengths, row.reason])
    heads = [
        "limit on",
        "",
        *(["URDF alone", "at most", "with corrected joints"] if two else ["found", "at most"]),
        "where the limit comes from, or what is missing",
    ]
    limits = report.limits
    source = limits.repeatability_source
    if limits.repeatability is not None:
        source = f"{1e3 * limits.repeatability:g} mm ({source})"
    return tag(
        "section",
        tag("h2", "Verdict, limit by limit"),
        table(heads, rows, "limits cards"),
        tag("p", f"The arm's repeatability: {source}.", class_="muted"),
        id="limits",
    )


def answers(report: ReportDocument, table_map: Element) -> Element:
    """Return the three questions that a user has, and their answers."""
    given = report.answers
    tolerance = tag(
        "input",
        type="number",
        min="0.01",
        step="0.05",
        value=f"{1e3 * report.tolerance:g}",
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
                tag("p", given.use.text, id="use-text", class_="answer-text"),
                tag("p", given.use.meaning),
                tag("p", given.use.alone) if given.use.alone else None,
                tag("p", given.use.between),
                tag("p", "What the ball cannot tell:"),
                tag("ul", [tag("li", line) for line in given.use.cannot_see]),
            ),
            tag(
                "article",
                tag("h3", "Which placement next?"),
                tag("p", given.next.text, id="next-text"),
                tag("h3", "Is my data all right?"),
                tag("p", given.data.text, id="data-text"),
                _checks(report),
            ),
            class_="columns",
        ),
        table_map,
        id="answers",
    )


def _checks(report: ReportDocument) -> Element | None:
    checks = [check for check in report.checks or () if check.level != "ok"]
    if not checks:
        return None
    return tag(
        "ul",
        [
            tag(
                "li",
                tag("strong", f"{check.level} "),
                f"{short_where(check.where)}: {check.text}; {check.advice or 'look at it'}",
                class_=check.level,
            )
            for check in checks
        ],
        class_="checks",
    )


def placements_table(report: ReportDocument) -> Element:
    """Return the errors at every placement, and whether the task can be done there."""
    names = short_names([row.name for row in report.placements])
    rows = [_placement_row(report, i, name) for i, name in enumerate(names)]
    heads = [
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
            tag("span", mm(report.tolerance), data_shown="tolerance"),
            ".",
            class_="muted",
        ),
        id="placements",
    )


_LEGEND = (
    "Errors: nominal \N{RIGHTWARDS ARROW} calibrated.urdf (with joint positions corrected first, "
    "where that differs), or calibrated.urdf alone. Where: as the robot "
    "sees it, x ahead and y to its left; placements may have been named from the other side. "
    "\u2018Yes\u2019: no sample was farther off, which with n samples still leaves a chance of up "
    "to 3 in n; \u2018mostly\u2019: 19 of 20 were not. What was trained on proves nothing. "
)


def _placement_row(report: ReportDocument, i: int, name: str) -> list[Cell]:
    row, path = report.placements[i], f"placements.{i}"
    use = report.answers.use.rows[i]
    two = row.geometric is not None
    role = "held out" if row.role == "test" else "trained on"
    loaded = "calibrated" if row.quantiles.geometric is None else "geometric"
    share = figure(report, f"{path}.within_tolerance", scale=100, digits=0)
    badge = tag("span", use.answer, class_=f"badge {use.answer.split(' ')[0]}", data_answer=i)
    return [
        tag("span", f"{i + 1} {name}", tag("small", role), class_="named"),
        use.where,
        "+".join(map(str, row.samples)),
        _pair(report, path, "mean_absolute_error", two=two),
        figure(report, f"{path}.quantiles.{loaded}.p95"),
        figure(report, f"{path}.quantiles.{loaded}.max"),
        _pair(report, path, "distance_error", "+", two=two),
        tag("span", share, " %", data_within=i),
        badge,
    ]


def _pair(report: ReportDocument, path: str, key: str, sign: str = "", *, two: bool) -> list[Node]:
    before = figure(report, f"{path}.nominal.{key}", digits=2, sign=sign)
    full = figure(report, f"{path}.calibrated.{key}", sign=sign)
    words: list[Node] = [tag("span", before, class_="before"), " \N{RIGHTWARDS ARROW} "]
    if two:
        return [*words, figure(report, f"{path}.geometric.{key}", sign=sign), " (", full, ")"]
    return [*words, full]

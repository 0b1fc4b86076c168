"""The fleet, as a page: which arms are well, what to record again, how each model differs."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from urllib.parse import quote

from ....solver.assessment import fixed, mm, plural
from ....solver.results import encode
from ...fleet import FleetArm, FleetDocument, FleetSession
from .html import Cell, Element, Node, figure, table, tag
from .html.frame import frame

_DASH = "\N{EN DASH}"


def summary_of(result: FleetDocument) -> str:
    """Return the state of the fleet in a sentence."""
    last = [arm.sessions[-1].status if arm.error is None else "error" for arm in result.arms]
    passed = last.count("pass")
    todo = sum(arm.again is not None for arm in result.arms)
    drifted = sum(
        session.drift is not None and session.drift.status == "invalid"
        for arm in result.arms
        for session in arm.sessions[-1:]
    )
    arms = plural(len(result.arms), "arm")
    return f"{passed} of {arms} pass; {drifted} drifted since the session before; {todo} to look at"


def fleet_page(result: FleetDocument) -> str:
    """Return the fleet as HTML."""
    body = [
        tag("header", tag("p", "Fleet", class_="kicker"), tag("h1", summary_of(result))),
        _again(result.arms),
        _arms(result),
        _drift(result),
        _parameters(result),
    ]
    return frame("Fleet", body, {"figures": encode(result, compact=True)})


def _again(arms: Sequence[FleetArm]) -> Element:
    rows: list[list[Cell]] = [[arm.name, arm.again] for arm in arms if arm.again is not None]
    content = table(["arm", "what to do"], rows, "cards") if rows else tag("p", "Nothing.")
    return tag("section", tag("h2", "What to record again, or to do"), content)


def _arms(result: FleetDocument) -> Element:
    rows: list[list[Cell]] = []
    for i, arm in enumerate(result.arms):
        if not arm.sessions:
            rows.append([arm.name, _DASH, _DASH, _DASH, _DASH, _DASH, "no calibration"])
            continue
        k = len(arm.sessions) - 1
        session, path = arm.sessions[k], f"arms.{i}.sessions.{k}"
        rows.append(
            [
                _named(arm.name, session),
                session.name or _DASH,
                f"{session.samples} at {plural(session.placements, 'placement')}",
                figure(result, f"{path}.nominal"),
                [figure(result, f"{path}.calibrated"), "" if session.held_out else " (of the fit)"],
                figure(result, f"{path}.distance_error"),
                _status(session),
            ]
        )
    heads = ["arm", "last session", "samples", "nominal, mm", "calibrated, mm", "socket distance "
             "error, mm", "verdict"]  # fmt: skip
    note = (
        "Mean absolute errors at the placement that was held out, by the URDF alone; where there "
        "was one placement only, of the fit itself, which proves little."
    )
    return tag("section", tag("h2", "All arms"), table(heads, rows, "cards"), tag("p", note))


def _named(arm: str, session: FleetSession) -> Node:
    """Return an arm's name, which leads to the report of a session where there is one."""
    if "report" not in session.outputs:
        return arm
    parts = (arm, session.name, Path(session.outputs["report"]).name)
    return tag("a", arm, href="/".join(quote(part) for part in parts if part))


def _status(session: FleetSession) -> str:
    return {"pass": "PASS", "fail": "FAIL", "incomplete": "not evaluated"}.get(
        session.status, session.status
    )


def _drift(result: FleetDocument) -> Element:
    rows: list[list[Cell]] = []
    for i, arm in enumerate(result.arms):
        for k, session in enumerate(arm.sessions):
            if session.drift is None:
                continue
            shown = figure(result, f"arms.{i}.sessions.{k}.drift.mean_absolute_error")
            since = f"{session.drift.since or 'the first'} at {session.name}"
            rows.append([arm.name, since, shown, session.drift.text.removeprefix("Verdict: ")])
    title = tag("h2", "Drift: each calibration on the recordings of the next session")
    if not rows:
        return tag("section", title, tag("p", "No arm has recordings of two sessions."))
    return tag(
        "section", title, table(["arm", "calibrated", "error, mm", "verdict"], rows, "cards")
    )


def _parameters(result: FleetDocument) -> Element:
    sections: list[Element] = []
    indices = range(len(result.parameters))
    for robot, group in groupby(indices, key=lambda i: result.parameters[i].robot):
        rows: list[list[Cell]] = []
        for i in group:
            row, path = result.parameters[i], f"parameters.{i}"
            unit = "mm" if row.unit == "m" else "mrad"
            change = f"{fixed(1e3 * row.change, 2, '+')} at {row.farthest}"
            rows.append(
                [
                    f"{row.name}, {unit}",
                    figure(result, f"{path}.mean", digits=2, sign="+"),
                    figure(result, f"{path}.spread", digits=2),
                    change,
                ]
            )
        heads = ["parameter", "mean change", "spread", "farthest from the mean"]
        arms = max(row.arms for row in result.parameters if row.robot == robot)
        sections += [tag("h3", f"{robot}, {plural(arms, 'arm')}"), table(heads, rows)]
    note = (
        "Changes from the nominal model, by each arm's last calibration. A mean that all arms "
        "share is wrong in the model itself; the spread is what each arm has of its own."
    )
    return tag("section", tag("h2", "Parameters over the fleet"), tag("p", note), sections)


def line_of(arm: FleetArm) -> tuple[str, str, str, str, str]:
    """Return an arm's row for a terminal: name, session, nominal, calibrated, verdict."""
    if not arm.sessions:
        return (arm.name, "-", "-", "-", "no calibration")
    session = arm.sessions[-1]
    status = _status(session) if arm.error is None else "no calibration of the last session"
    return (arm.name, session.name or "-", mm(session.nominal), mm(session.calibrated), status)

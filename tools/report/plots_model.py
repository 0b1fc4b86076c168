"""Plots of the model: its parameters, what moved while recording, and the groups of the fit."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .answer_next import HARDLY_MOVED
from .plot import Figures, Plot
from .svg import Axis, Rows
from .words import joined, short_names

__all__ = ["coverage", "groups", "parameters", "shown_unit"]

_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad"), "rad/(N m)": (1e6, "\N{MICRO SIGN}rad/(N m)")}
"""Factor and unit on the screen, by SI unit."""
_DEGREES = 180 / np.pi


def shown_unit(unit: str) -> tuple[float, str]:
    """Return the factor and the name of the unit in which people read a parameter."""
    return _SHOWN.get(unit, (1.0, unit))


def parameters(figures: Figures) -> Plot:
    """What the calibration changed, as bars, with standard deviations where there are any."""
    kinds = parameter_kinds(figures)
    known = [row for rows in kinds.values() for row in rows if row.get("standard_deviation")]
    marks = (("change", "change"), ("deviation", "\N{PLUS-MINUS SIGN} one standard deviation"))
    return Plot(
        "parameters",
        "What changed",
        _parameter_sentence(kinds, known),
        tuple(_bars(kind, rows) for kind, rows in kinds.items()),
        marks if known else marks[:1],
    )


def parameter_kinds(figures: Figures) -> dict[str, list[dict[str, Any]]]:
    """Return name, unit, change and deviation of all parameters and coefficients, by kind."""
    kinds: dict[str, list[dict[str, Any]]] = {}
    for row in figures["parameters"]:
        kind = "joint origins, places" if row["unit"] == "m" else "joint origins, angles"
        kinds.setdefault(kind, []).append(row)
    for row in figures.get("coefficients", []):
        kind = "joint compliance" if row["unit"] == "rad/(N m)" else "transmission error"
        if row["value"] or row["standard_deviation"]:  # the others are switched off
            kinds.setdefault(kind, []).append({**row, "change": row["value"]})
    return kinds


def _bars(kind: str, rows: Sequence[Figures]) -> Any:
    factor, shown = shown_unit(rows[0]["unit"])
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    largest = max(abs(row["change"]) for row in rows)
    ends = [abs(row["change"]) + min(row.get("standard_deviation") or 0, largest) for row in rows]
    half = 1.1 * factor * max(*ends, 1e-9)
    names = [row["name"].removesuffix(".compliance") for row in rows]
    panel = Rows(f"{kind}, {shown}", names, Axis(-half, half, shown), pitch=15)
    panel.vertical(0, "zero")
    for i, row in enumerate(rows):
        change, deviation = factor * row["change"], factor * (row.get("standard_deviation") or 0)
        panel.span(i, 0, change, "change", thick=8)
        if deviation:
            panel.span(i, change - deviation, change + deviation, "deviation", thick=2)
    return panel.root


def _parameter_sentence(kinds: dict[str, list[dict[str, Any]]], known: Sequence[Figures]) -> str:
    parts: list[str] = []
    for rows in kinds.values():
        factor, shown = shown_unit(rows[0]["unit"])
        row = max(rows, key=lambda r: abs(r["change"]))
        parts.append(f"{row['name']} by {factor * row['change']:+.2f} {shown}")
    if not known:
        return f"The largest changes are {joined(parts)}; this method gives no standard deviations."
    clear = sum(abs(row["change"]) > 2 * row["standard_deviation"] for row in known)
    return (
        f"The largest changes are {joined(parts)}, and {clear} of {len(known)} are beyond two of "
        "their standard deviations."
    )


def coverage(figures: Figures) -> Plot:
    """Where each joint was in each socket, within its limits, and how far it turned."""
    turning = [i for i, j in enumerate(figures["coverage"]["joints"]) if j["unit"] == "rad"]
    sliding = [i for i, j in enumerate(figures["coverage"]["joints"]) if j["unit"] == "m"]
    panels = [
        draw(figures, which, factor, unit)
        for which, factor, unit in ((turning, _DEGREES, "degrees"), (sliding, 1e3, "mm"))
        if which
        for draw in (_positions, _spans)
    ]
    return Plot(
        "coverage",
        "How the joints moved",
        _coverage_sentence(figures, turning),
        tuple(panels),
        (("tick-train", "trained on"), ("tick-test", "held out"), ("range", "joint limits")),
    )


def _positions(figures: Figures, joints: Sequence[int], factor: float, unit: str) -> Any:
    found = figures["coverage"]
    rows = [found["joints"][i] for i in joints]
    lows = [factor * socket["low"][i] for socket in found["sockets"] for i in joints]
    highs = [factor * socket["high"][i] for socket in found["sockets"] for i in joints]
    low = min(lows + [factor * row["lower"] for row in rows if row["lower"] is not None])
    high = max(highs + [factor * row["upper"] for row in rows if row["upper"] is not None])
    panel = Rows(
        f"positions, {unit}; socket 0 above, others below",
        [row["name"] for row in rows],
        Axis(low, max(high, low + 1e-6), unit),
        pitch=34,
    )
    for k, i in enumerate(joints):
        row = rows[k]
        if row["lower"] is not None and row["upper"] is not None:
            panel.span(k, factor * row["lower"], factor * row["upper"], "range", thick=26)
        for role in ("test", "train"):
            upper, lower = panel.row(k) - 12, panel.row(k) + 1
            marks = "".join(
                f"M{panel.x(factor * q[i]):.1f} {lower if s['socket'] else upper:.1f}v11"
                for s in found["sockets"]
                if s["role"] == role
                for q in s["positions"]
            )
            if marks:
                panel.add("path", d=marks, class_=f"tick-{role}")
    return panel.root


def _spans(figures: Figures, joints: Sequence[int], factor: float, unit: str) -> Any:
    found = figures["coverage"]
    names = [found["joints"][i]["name"] for i in joints]
    spans = [
        (k, factor * (s["high"][i] - s["low"][i]), s)
        for k, i in enumerate(joints)
        for s in found["sockets"]
    ]
    high = 1.05 * max(*(span for _, span, _ in spans), 1e-6)
    panel = Rows(f"how far it moved in each socket, {unit}", names, Axis(0, high, unit), pitch=34)
    for k, span, socket in spans:
        hint = f"{socket['placement']}, socket {socket['socket']}: {span:.0f} {unit}"
        panel.mark(k, span, f"curve-dot {socket['role']}", hint)
    if unit == "degrees":
        limit = HARDLY_MOVED * _DEGREES
        panel.threshold(limit, f"at least {limit:.0f} degrees", vertical=True)
    return panel.root


def _coverage_sentence(figures: Figures, turning: Sequence[int]) -> str:
    found = figures["coverage"]
    spans = [
        (s["high"][i] - s["low"][i], found["joints"][i]["name"], s)
        for i in turning
        for s in found["sockets"]
    ]
    if not spans:
        return "No joint of this arm turns, so there is no angle to cover."
    span, joint, socket = min(spans, key=lambda row: row[0])
    places = short_names([s["placement"] for s in found["sockets"]])
    place = dict(zip(map(id, found["sockets"]), places, strict=True))[id(socket)]
    count = sum(row[0] < HARDLY_MOVED for row in spans)
    return (
        f"{joint} moved least, {span * _DEGREES:.0f} degrees in socket {socket['socket']} of "
        f"{place}; of {len(spans)} pairs of joint and socket {count or 'none'} moved less than the "
        f"dashed {HARDLY_MOVED * _DEGREES:.0f} degrees."
    )


def groups(figures: Figures) -> Plot | None:
    """How many parameters of each group the data settle, of how many there are."""
    rows = [row for row in figures.get("groups", []) if row["unit"] in _SHOWN]
    if not rows:
        return None
    names = [row["name"].replace("_", " ") for row in rows]
    panel = Rows("share of the group that the data settle", names, Axis(0, 100, "%"), pitch=28)
    for i, row in enumerate(rows):
        share = 100 * row["effective"] / max(row["count"], 1)
        panel.span(i, 0, 100, "range", thick=16)
        panel.span(i, 0, share, "change", thick=16)
        words = f"{row['effective']:.1f} of {row['count']}" if row["active"] else "off"
        panel.text(panel.x(min(share, 62)) + 6, panel.row(i) + 4, words, "tick")
    on = [name for name, row in zip(names, rows, strict=True) if row["active"]]
    off = [name for name, row in zip(names, rows, strict=True) if not row["active"]]
    total = sum(row["effective"] for row in rows)
    return Plot(
        "groups",
        "What the data settle",
        f"The data settle {total:.0f} of {sum(row['count'] for row in rows)} parameters, support "
        f"{joined(on) or 'no group'}, and switch off {joined(off) or 'none'}.",
        (panel.root,),
        (("change", "settled by the data"), ("range", "left to the prior")),
        "half",
    )

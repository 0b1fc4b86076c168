"""Are my recordings all right? The answer: checks, floors, and the farthest samples."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .words import joined, mm, plural, short_names

__all__ = ["FAR", "data_answer", "placements_with_errors"]

FAR = 3.0
"""A sample this many times its placement's mean error from its socket deserves a look."""
STANDS_OUT = 2.5
"""A placement that leaves this many times the best one's error, both fitted alone, is suspect."""


def data_answer(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return whether the recordings look sound: the checks, the floors, the farthest samples."""
    worst = worst_samples(figures)
    floors = _floors(figures)
    texts = [_checks_text(figures)]
    if floors:
        words = _floors_text(floors)
        texts.append(words if texts[0].endswith(":") else words[0].upper() + words[1:])
    beyond = sum(row["ratio"] > FAR for row in worst)
    if beyond:
        first = worst[0]
        texts.append(
            f"Look at {first['where']}: it is {mm(first['error'])} from its socket, "
            f"{first['ratio']:.1f} times its placement's mean error."
        )
    return {"text": " ".join(texts), "worst": worst[:5], "floors": floors}


def _checks_text(figures: Mapping[str, Any]) -> str:
    checks = figures.get("checks")
    if checks is None:
        return (
            "Not known: the recordings were not checked one by one, which mukca check does. What "
            "the fits show:"
        )
    errors = [check for check in checks if check["level"] == "error"]
    warnings = [check for check in checks if check["level"] == "warning"]
    if not errors and not warnings:
        return "Yes: the checks of the recordings found nothing wrong."
    if not errors:
        return f"Yes, but look at {plural(len(warnings), 'warning')} below."
    text = f"No: {plural(len(errors), 'error')} below; mend or record anew, then calibrate again."
    trained = [name for name, role in placements_with_errors(figures).items() if role == "train"]
    if trained:
        text += f" All figures here rest on {joined(trained)}, trained on."
    return text


def placements_with_errors(figures: Mapping[str, Any]) -> dict[str, str]:
    """Return short names and roles of the placements in which the checks found errors."""
    checks: list[dict[str, Any]] = figures.get("checks") or []
    places = [f"/{check['where']}/" for check in checks if check["level"] == "error"]
    names = short_names([row["name"] for row in figures["placements"]])
    return {
        name: row["role"]
        for name, row in zip(names, figures["placements"], strict=True)
        if any(f"/{row['name']}/" in place for place in places)
    }


def _floors(figures: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what each placement leaves when fitted alone, the diagonal of the matrix."""
    matrix = figures["cross_placement"]
    if matrix is None:
        return []
    return [
        {"name": name, "mean_absolute_error": row[i]}
        for i, (name, row) in enumerate(
            zip(short_names(matrix["names"]), matrix["matrix"], strict=True)
        )
        if row is not None
    ]


def _floors_text(floors: Sequence[Mapping[str, Any]]) -> str:
    values = [row["mean_absolute_error"] for row in floors]
    low, high = min(values), max(values)
    text = f"fitted alone, each placement leaves {mm(low)} to {mm(high)}"
    odd = [row["name"] for row in floors if row["mean_absolute_error"] > STANDS_OUT * low]
    if odd:
        return f"{text}: {joined(odd)} stands out, so record it anew."
    return f"{text}: none stands out."


def worst_samples(figures: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the samples by falling calibrated error, with that error [m] and its ratio.

    The ratio is to the mean absolute error of the sample's placement.
    """
    rows: list[dict[str, Any]] = []
    for row in figures["samples"]:
        placement = figures["placements"][row["placement"]]
        error = float(np.linalg.norm(row["calibrated"]))
        mean = placement["calibrated"]["mean_absolute_error"]
        rows.append(
            {
                "where": row["where"] or f"{placement['name']}, sample {row['number']}",
                "name": placement["name"],
                "socket": row["socket"],
                "number": row["number"],
                "weight": row.get("weight"),
                "error": error,
                "ratio": error / mean if mean > 0 else 0.0,
            }
        )
    return sorted(rows, key=lambda row: -row["error"])

"""The figures of a report: everything that it shows, as one JSON object in SI units."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...solver.data.observations import KnownDistance
from .answer_data import data_answer
from .answer_next import next_answer
from .answer_use import use_answer
from .arm import arm_figures
from .between import between
from .evidence import MODELS, Evidence, Seen, short_where
from .limits import LIMITED, limits_for
from .matrix import cross_placement
from .verdict import verdict

__all__ = ["FORMAT", "Options", "report_figures"]

FORMAT = "mukca-report-1"
DRAWN = 3000
"""Samples drawn at most; figures rest on all of them."""
_OPTIONAL = (
    "checks",
    "choices",
    "coefficients",
    "groups",
    "log_evidence",
    "next_placement",
    "noise",
    "uncertainty",
)
"""What only some methods leave in the file."""


@dataclass(frozen=True)
class Options:
    """What the user may choose about a report."""

    repeatability: float | None = None
    """Of the arm [m]; None for what is known of it."""
    mean_absolute_error: float | None = None
    """Limit [m]; None, here and below, for what the repeatability says."""
    distance_error: float | None = None
    between_placements: float | None = None
    known: Sequence[KnownDistance] = ()
    tolerance: float = 5e-4
    """The error that the user's task allows [m]."""


def report_figures(evidence: Evidence, options: Options, command: str) -> dict[str, Any]:
    """Return the figures of a report.

    Args:
        evidence: The calibration.
        options: Limits, known distances, the task's tolerance.
        command: What reproduces the calibration.

    Raises:
        KnownError: A known distance names no socket of the calibration.
    """
    document = evidence.document
    given = {name: getattr(options, name) for name in LIMITED}
    limits = limits_for(document["model"], options.repeatability, given)
    figures: dict[str, Any] = {
        "format": FORMAT,
        **{key: document[key] for key in ("robot", "method", "optimizer", "iterations")},
        "robot_name": evidence.robot.name,
        "summary": _summaries(evidence, options.tolerance),
        "placements": [
            {**row, **_place(seen, options.tolerance)}
            for row, seen in zip(document["placements"], evidence.placements, strict=True)
        ],
        "between": between(evidence, options.known),
        "tolerance": options.tolerance,
        "limits": asdict(limits),
        "samples": _samples(evidence),
        "history": document["history"],
        "cross_placement": cross_placement(evidence),
        "coverage": _coverage(evidence),
        "parameters": document["parameters"],
        **{key: document[key] for key in _OPTIONAL if key in document},
        "warnings": document.get("warnings", []),
        "provenance": {**document["provenance"], "settings": document["settings"]},
        "command": command,
    }
    figures["verdict"] = verdict(figures, limits)
    figures["answers"] = {
        "use": use_answer(figures),
        "next": next_answer(figures),
        "data": data_answer(figures),
    }
    figures["arm"] = arm_figures(evidence)
    return figures


def _summaries(evidence: Evidence, tolerance: float) -> dict[str, Any]:
    """Return the file's summaries, and the quantiles over all samples of each role."""
    summary: dict[str, Any] = {}
    for role in ("train", "test"):
        given = evidence.document["summary"][role]
        seen = evidence.of_role(role)
        if given is None or not seen:
            summary[role] = None
            continue
        errors = {model: np.concatenate([s.errors(model) for s in seen]) for model in MODELS}
        summary[role] = {
            **given,
            "placements": len(seen),
            "samples": sum(len(s.samples) for s in seen),
            "quantiles": {model: quantiles(values) for model, values in errors.items()},
            "within_tolerance": {
                model: float(np.mean(values <= tolerance)) for model, values in errors.items()
            },
        }
    return summary


def quantiles(errors: Any) -> dict[str, float]:
    """Return the median, the 95th percentile and the maximum."""
    median, high = np.quantile(errors, (0.5, 0.95)).tolist()
    return {"median": median, "p95": high, "max": float(np.max(errors))}


def _place(seen: Seen, tolerance: float) -> dict[str, Any]:
    errors = seen.errors("calibrated")
    return {
        "position": seen.position.tolist(),
        "sockets": [
            {"socket": k, "centre": centre.tolist()}
            for k, centre in zip(seen.measured.sockets, seen.centres(), strict=True)
        ],
        "quantiles": {model: quantiles(seen.errors(model)) for model in MODELS},
        "within_tolerance": float(np.mean(errors <= tolerance)),
    }


def _samples(evidence: Evidence) -> list[dict[str, Any]]:
    """Return every sample's deviation from its socket's mean by both models [m]."""
    rows = [row for i, seen in enumerate(evidence.placements) for row in _deviations(i, seen)]
    return rows[:: -(-len(rows) // DRAWN)]


def _deviations(placement: int, seen: Seen) -> list[dict[str, Any]]:
    numbers: dict[int, int] = {}
    rows: list[dict[str, Any]] = []
    for i, sample in enumerate(seen.samples):
        socket = int(sample["socket"])
        numbers[socket] = numbers.get(socket, 0) + 1
        row: dict[str, Any] = {
            "placement": placement,
            "socket": socket,
            "number": numbers[socket],
            "where": short_where(str(sample.get("where", ""))),
            **{model: _rounded(seen.deviations[model][i]) for model in MODELS},
        }
        if isinstance(sample.get("weight"), int | float):
            row["weight"] = float(sample["weight"])
        rows.append(row)
    return rows


def _rounded(vector: Any) -> list[float]:
    """Return a vector to hundredths of a micrometre."""
    return [round(value, 8) for value in map(float, vector)]


def _coverage(evidence: Evidence) -> dict[str, Any]:
    """Return how far each joint moved in each socket [rad], [m] for a prismatic joint."""
    return {
        "joints": [
            {
                "name": joint.name,
                "unit": "m" if joint.type == "prismatic" else "rad",
                "lower": joint.lower if np.isfinite(joint.lower) else None,
                "upper": joint.upper if np.isfinite(joint.upper) else None,
            }
            for joint in evidence.robot.actuated
        ],
        "sockets": [
            {
                "placement": seen.name,
                "role": seen.role,
                "socket": k,
                "low": rows.min(axis=0).tolist(),
                "high": rows.max(axis=0).tolist(),
                "positions": np.round(rows[:: -(-len(rows) // DRAWN)], 4).tolist(),
            }
            for seen in evidence.placements
            for k, rows in zip(seen.measured.sockets, seen.measured.by_socket, strict=True)
        ],
    }

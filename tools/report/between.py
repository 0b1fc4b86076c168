"""Distances between sockets that were measured from outside, against those the models predict."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...solver.data.observations import KnownDistance, KnownError
from .evidence import MODELS, Evidence, Seen

__all__ = ["between"]


def between(evidence: Evidence, known: Sequence[KnownDistance]) -> list[dict[str, Any]]:
    """Return each known distance and the errors of the models [m].

    Raises:
        KnownError: One names a placement or socket that the calibration has no samples of.
    """
    fitted = bool(evidence.document["settings"].get("known"))
    rows: list[dict[str, Any]] = []
    for one in known:
        a, b = (_find(evidence, name) for name, _ in (one.first, one.second))
        row: dict[str, Any] = {
            "a": f"{a.name}:{one.first[1]}",
            "b": f"{b.name}:{one.second[1]}",
            "distance": one.distance,
            "standard_deviation": one.deviation,
            # What the fit was told proves nothing; it can be told only of what it was trained on.
            "in_fit": fitted and a.role == b.role == "train",
        }
        for model in MODELS:
            span = _centre(b, one.second[1], model) - _centre(a, one.first[1], model)
            row[f"{model}_error"] = float(np.linalg.norm(span)) - one.distance
        rows.append(row)
    return rows


def _find(evidence: Evidence, name: str) -> Seen:
    for matches in (
        [seen for seen in evidence.placements if seen.name == name],
        [seen for seen in evidence.placements if seen.name.split("/")[-1] == name],
    ):
        if len(matches) == 1:
            return matches[0]
    names = ", ".join(seen.name for seen in evidence.placements)
    raise KnownError(f"known distance: {name!r} names no one placement; there are: {names}")


def _centre(seen: Seen, socket: int, model: str) -> Any:
    if socket not in seen.measured.sockets:
        raise KnownError(f"known distance: {seen.name} has no samples in socket {socket}")
    return seen.centres(model)[seen.measured.sockets.index(socket)]

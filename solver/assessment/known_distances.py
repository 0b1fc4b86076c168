"""Distances between sockets that were measured from outside, against those the models predict."""

from collections.abc import Sequence

import numpy as np

from ..data import KnownDistance, KnownError
from ..results import Document
from .predictions import ModelName, PlacementPrediction, Predictions, norms


class KnownDistanceErrors(Document, kw_only=True, frozen=True):
    """A distance between two sockets that was measured from outside, and how far models are off."""

    a: str
    """``PLACEMENT:SOCKET``."""
    b: str
    distance: float
    """As measured [m]."""
    standard_deviation: float
    """Of the measurement [m]."""
    in_fit: bool
    """True if the calibration was fitted to it: then it proves nothing."""
    nominal_error: float
    """Predicted less measured [m]."""
    calibrated_error: float
    geometric_error: float | None = None

    def error(self, model: ModelName) -> float:
        """Return the error of one model [m]."""
        if model == "geometric" and self.geometric_error is not None:
            return self.geometric_error
        return self.nominal_error if model == "nominal" else self.calibrated_error


def known_distance_errors(
    predictions: Predictions, known: Sequence[KnownDistance]
) -> tuple[KnownDistanceErrors, ...]:
    """Return the errors of both models at each known distance; raises KnownError."""
    return tuple(_errors(predictions, one) for one in known)


def _errors(predictions: Predictions, known: KnownDistance) -> KnownDistanceErrors:
    (a, socket_a), (b, socket_b) = (
        (_placement(predictions, name), socket) for name, socket in (known.first, known.second)
    )

    def error(model: ModelName) -> float:
        span = _centre(b, socket_b, model) - _centre(a, socket_a, model)
        return float(norms(span)) - known.distance

    # What the fit was told proves nothing; it can be told only of what it was trained on.
    fitted = bool(predictions.document.settings.get("known"))
    return KnownDistanceErrors(
        a=f"{a.name}:{socket_a}",
        b=f"{b.name}:{socket_b}",
        distance=known.distance,
        standard_deviation=known.deviation,
        in_fit=fitted and a.role == b.role == "train",
        nominal_error=error("nominal"),
        calibrated_error=error("calibrated"),
        geometric_error=None if a.points.geometric is None else error("geometric"),
    )


def _placement(predictions: Predictions, name: str) -> PlacementPrediction:
    """Return the placement that a user means, by its whole name or the last part of it."""
    for matches in (
        [one for one in predictions.placements if one.name == name],
        [one for one in predictions.placements if one.name.split("/")[-1] == name],
    ):
        if len(matches) == 1:
            return matches[0]
    names = ", ".join(one.name for one in predictions.placements)
    raise KnownError(f"known distance: {name!r} names no one placement; there are: {names}")


def _centre(placement: PlacementPrediction, socket: int, model: ModelName) -> np.ndarray:
    if socket not in placement.measured.sockets:
        raise KnownError(f"known distance: {placement.name} has no samples in socket {socket}")
    return placement.centres(model)[placement.measured.sockets.index(socket)]

"""The figures of a calibration: per placement, in summary, and over the iterations."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .calibrated import Calibration
from .data.measurements import Measurement
from .data.metrics import Metrics, cost_terms, evaluate, mean_metrics
from .paper.problem import Fit

__all__ = ["figures", "history", "samples", "summarise"]

Vector = NDArray[np.float64]
Models = dict[str, Callable[[Measurement], Vector]]
"""The models that are compared: name, and how each predicts the balls of a placement."""


def models_of(calibration: Calibration, ball_refitted: Fit | None = None) -> Models:
    """Return the models to compare.

    Nominal, calibrated, the exported geometry where it differs, and nominal with the ball
    refitted where that is given.
    """
    models: Models = {
        "nominal": lambda m: calibration.nominal_ball(m.positions),
        "calibrated": lambda m: calibration.ball(m.positions, m.efforts),
    }
    if calibration.exported is not None:
        models["geometric"] = lambda m: calibration.geometric_ball(m.positions)
    if ball_refitted is not None:
        fit = ball_refitted
        models["ball_refitted"] = lambda m: fit.problem.model.points(fit.x, m.positions)
    return models


def figures(
    models: Models, train: Sequence[Measurement], test: Sequence[Measurement]
) -> dict[str, Any]:
    """Return ``placements`` and ``summary`` of the machine-readable result, SI units.

    Args:
        models: What to compare.
        train: Placements that the calibration was fitted to.
        test: Placements held out.
    """
    rows: list[dict[str, Any]] = []
    summary: dict[str, Any] = {}
    for role, placements in (("train", train), ("test", test)):
        metrics = {
            name: [evaluate(predict(m), m) for m in placements] for name, predict in models.items()
        }
        for i, measured in enumerate(placements):
            rows.append(
                {
                    "name": measured.name,
                    "role": role,
                    "samples": list(measured.counts),
                    "distance": measured.distance,
                    **{name: of_model[i].as_dict() for name, of_model in metrics.items()},
                }
            )
        summary[role] = summarise(metrics) if placements else None
    return {"placements": rows, "summary": summary}


def summarise(metrics: dict[str, list[Metrics]]) -> dict[str, Any]:
    """Return the means over placements for each model, and the error removed by the calibration."""
    means = {name: mean_metrics(of_model) for name, of_model in metrics.items()}
    before = means["nominal"].mean_absolute_error
    after = means["calibrated"].mean_absolute_error
    removed = 1 - after / before if before > 0 else 0.0
    return {**{name: m.as_dict() for name, m in means.items()}, "removed_error": removed}


def history(
    iterates: Sequence[Callable[[Measurement], Vector]],
    train: Sequence[Measurement],
    test: Sequence[Measurement],
) -> list[dict[str, Any]]:
    """Return inconsistency and distortion [m^2] after each iteration, mean over placements.

    Args:
        iterates: How the model predicts the balls of a placement, the nominal one first.
        train: Placements that the calibration was fitted to.
        test: Placements held out.
    """

    def terms(
        predict: Callable[[Measurement], Vector], placements: Sequence[Measurement]
    ) -> dict[str, float] | None:
        if not placements:
            return None
        pairs = [cost_terms(predict(m), m) for m in placements]
        inconsistency, distortion = np.mean(pairs, axis=0).tolist()
        return {"inconsistency": inconsistency, "distortion": distortion}

    return [
        {"iteration": i, "train": terms(predict, train), "test": terms(predict, test)}
        for i, predict in enumerate(iterates)
    ]


def samples(
    measured: Measurement, role: str, weights: Sequence[float] | None = None
) -> dict[str, Any]:
    """Return a placement's samples for the calibration file, columns in chain order.

    Args:
        measured: The placement.
        role: ``train`` or ``test``.
        weights: Robust weight of each sample, where the fit gave some.
    """
    return {
        "name": measured.name,
        "role": role,
        "distance": measured.distance,
        "files": [str(file) for file in measured.placement.files],
        "samples": [
            {
                "socket": sample.socket,
                "position": list(sample.position),
                "effort": None if sample.effort is None else list(sample.effort),
                "where": sample.where,
                **({} if weights is None else {"weight": weights[i]}),
            }
            for i, sample in enumerate(measured.placement.samples)
        ],
    }

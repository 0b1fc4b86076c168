"""The cross-placement matrix, the paper's Fig. 6: trained on which placement, error where."""

from dataclasses import replace

from ....errors import MukcaError
from ....solver.assessment import PlacementPrediction, Predictions
from ....solver.data import evaluate
from ....solver.paper import REGULARIZATION, Problem, build_problem, solve
from ....solver.robot import Parameter, all_parameters
from .types import CrossPlacement


def cross_placement(
    predictions: Predictions, regularization: float | None
) -> CrossPlacement | None:
    """Return the errors of every placement by models trained on each placement alone.

    Each placement is fitted alone by Eq. (5), which takes some 10 ms each, with the joint origins
    that the calibration itself had free. None with fewer than two placements.

    Args:
        predictions: The calibration.
        regularization: Weight of the last term of Eq. (5); None for the default.
    """
    if len(predictions.placements) < 2:
        return None
    problem = build_problem(
        predictions.robot,
        [placement.measured for placement in predictions.placements],
        parameters=_geometry(predictions),
        regularization=REGULARIZATION if regularization is None else regularization,
    )
    return CrossPlacement(
        method="Eq. (5)",
        names=tuple(placement.name for placement in predictions.placements),
        matrix=tuple(_row(problem, placement) for placement in predictions.placements),
    )


def _geometry(predictions: Predictions) -> list[Parameter]:
    """Return the joint origins among the calibrated parameters."""
    chosen = {parameter.name for parameter in predictions.calibration.parameters}
    return [p for p in all_parameters(predictions.robot) if p.name in chosen]


def _row(problem: Problem, trained_on: PlacementPrediction) -> tuple[float, ...] | None:
    if not trained_on.measured.has_distance:
        return None
    try:
        x = solve(replace(problem, training=(trained_on.measured,))).x
    except MukcaError:
        return None
    return tuple(
        evaluate(problem.model.points(x, m.positions), m).mean_absolute_error
        for m in problem.training
    )

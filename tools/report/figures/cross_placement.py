"""The cross-placement matrix, the paper's Fig. 6: trained on which placement, error where."""

from dataclasses import replace

from ....errors import MukcaError
from ....solver.assessment import PlacementPrediction, Predictions
from ....solver.data import evaluate
from ....solver.paper import REGULARIZATION, Problem, build_problem, solve
from ....solver.robot import all_parameters
from .types import CrossPlacement


def cross_placement(
    predictions: Predictions, regularization: float | None
) -> CrossPlacement | None:
    """Return the errors everywhere by models trained on each placement alone; None for only one."""
    if len(predictions.placements) < 2:
        return None
    # By Eq. (5), some 10 ms each, with the joint origins that the calibration itself had free.
    chosen = {parameter.name for parameter in predictions.calibration.parameters}
    problem = build_problem(
        predictions.robot,
        [placement.measured for placement in predictions.placements],
        parameters=[p for p in all_parameters(predictions.robot) if p.name in chosen],
        regularization=REGULARIZATION if regularization is None else regularization,
    )
    return CrossPlacement(
        method="Eq. (5)",
        names=tuple(placement.name for placement in predictions.placements),
        matrix=tuple(_row(problem, placement) for placement in predictions.placements),
    )


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

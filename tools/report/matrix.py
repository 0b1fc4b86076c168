"""The cross-placement matrix, the paper's Fig. 6: trained on which placement, error where."""

from dataclasses import replace
from typing import Any

from ... import MukcaError
from ...solver.data.metrics import evaluate
from ...solver.paper.problem import REGULARIZATION, Problem, build_problem, solve
from ...solver.robot.parameters import Parameter, all_parameters
from .evidence import Evidence, Seen

__all__ = ["cross_placement"]


def cross_placement(evidence: Evidence) -> dict[str, Any] | None:
    """Return the errors of every placement by models trained on each placement alone.

    The calibration's own matrix is taken where it has one; otherwise each placement is fitted
    alone by Eq. (5), which takes some 10 ms each.

    Returns:
        ``names``, ``method`` and ``matrix``, whose entry [i][j] is the MAE [m] on placement j
        after training on i, or None where it cannot be fitted alone.
        None with fewer than two placements.
    """
    given = evidence.document.get("cross_placement")
    if given is not None:
        return {"method": str(evidence.document["method"]), **given}
    if len(evidence.placements) < 2:
        return None
    problem = build_problem(
        evidence.robot,
        [seen.measured for seen in evidence.placements],
        parameters=_geometry(evidence),
        regularization=evidence.document["settings"].get("regularization", REGULARIZATION),
    )
    return {
        "method": "Eq. (5)",
        "names": [seen.name for seen in evidence.placements],
        "matrix": [_row(problem, seen) for seen in evidence.placements],
    }


def _geometry(evidence: Evidence) -> list[Parameter]:
    """Return the joint origins among the calibrated parameters."""
    chosen = {parameter.name for parameter in evidence.calibration.parameters}
    return [p for p in all_parameters(evidence.robot) if p.name in chosen]


def _row(problem: Problem, trained_on: Seen) -> list[float] | None:
    if not trained_on.measured.has_distance:
        return None
    try:
        x = solve(replace(problem, training=(trained_on.measured,))).x
    except MukcaError:
        return None
    return [
        evaluate(problem.model.points(x, m.positions), m).mean_absolute_error
        for m in problem.training
    ]

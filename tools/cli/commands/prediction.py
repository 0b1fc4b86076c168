"""Accuracy that a calibration on some recordings would have, before it is made."""

from ....solver import calibration, design


def predicted_accuracy(
    problem: "calibration.CalibrationProblem",
) -> "design.Accuracy | None":
    """Return the accuracy by a fit to all recordings; None where a fit cannot tell it."""
    settings = problem.options
    return design.accuracy_by(
        problem.robot,
        problem.measurements,
        settings.load,
        settings.distances,
        settings.deviation,
        zeros=bool(settings.zeros),
    )

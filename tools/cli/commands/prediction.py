"""Accuracy that a calibration on some recordings would have, before it is made."""

from ....solver import assessment, calibration, design


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


def in_words(
    accuracy: "design.Accuracy",
    problem: "calibration.CalibrationProblem",
) -> str:
    """Return that accuracy in words, beside the robot's repeatability."""
    repeatability = assessment.repeatability_of(
        problem.robot, problem.options.repeatability_mm
    )
    return assessment.predicted_in_words(
        accuracy.better.workspace.now, accuracy.length, repeatability
    )

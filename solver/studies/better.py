"""Study: the errors of distances that a calibration improves."""

from ..results import (
    Better,
    CalibratedRobot,
    Fit,
    Measurements,
    Place,
    Study,
    with_ball_at,
)
from .improvement import Models, better_than_nominal


def better(fit: Fit, measurements: Measurements, ball: Place | None) -> Better | None:
    """Return the errors of distances before and now.

    Before is the nominal robot with its ball refitted at ``ball``, or with the calibrated one:
    whichever errs less. A model that is wrong elsewhere puts the ball wrong by millimetres.
    """
    assert fit.posterior is not None
    calibrated: CalibratedRobot = fit.calibrated
    nominal = [with_ball_at(calibrated.robot, ball), calibrated.with_ball_alone]
    models = Models(
        [robot.ball for robot in nominal if robot is not None],
        calibrated.geometric_ball,
        corrected=calibrated.exported is not None,
    )
    recorded = [m for _, m in measurements.placements]
    return better_than_nominal(
        fit.posterior, calibrated.load, models, recorded, measurements.unseen(fit)
    )


BETTER = Study("better", better, ("refitted_ball",))

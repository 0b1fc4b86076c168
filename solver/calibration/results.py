"""Document of a calibration: a fit and its figures, as ``calibration.json`` holds them."""

from collections.abc import Sequence

from .. import results
from ..identification.data import as_point, is_distorted
from ..identification.robot import Robot
from . import estimates
from .errors import Errors, errors_of, history, left_out_errors
from .problem import CalibrationProblem
from .refitted_ball import ball_refitted
from .sources import provenance_of, samples_of

UNKNOWN = (
    "how well the calibration is known could not be computed: the samples are too few or too much "
    "alike; record more that differ"
)


def document_of(
    problem: CalibrationProblem, fit: results.Fit, studies: Sequence[results.Study]
) -> results.CalibrationDocument:
    """Return all that is to be kept of a calibration; nothing is written yet."""
    if fit.full is not None:
        shifts = fit.posterior and fit.posterior.moved
        problem = problem.at_rest(shifts, fit.calibrated)
    return results.studied(_fitted(problem, fit), fit, problem, studies)


def _fitted(
    problem: CalibrationProblem, fit: results.Fit
) -> results.CalibrationDocument:
    """Return a fit and the errors of its model, before any study."""
    calibrated = fit.calibrated
    options = problem.options
    robot = problem.robot
    full = fit.full
    before = ball_refitted(problem)
    errors = errors_of(problem, fit, before)
    left_out = left_out_errors(problem.folds)
    distorted = tuple(
        m.name for m in problem.measurements if is_distorted(calibrated.predict(m), m)
    )
    return results.CalibrationDocument(
        format=results.FORMAT,
        robot=robot.source,
        method=options.method,
        optimizer=fit.optimizer,
        iterations=len(fit.iterates) - 1,
        converged=True,
        solve_seconds=fit.seconds,
        placements=errors.placements,
        summary=Errors([*errors, *left_out]).summary,
        left_out=tuple(left_out),
        distorted=distorted,
        parameters=estimates.parameter_values(calibrated),
        rotation_numbers=calibrated.rotation_numbers,
        choices=full and full.notes,
        history=history(fit.iterates, problem.measurements, problem.test),
        settings={**robot.loaded_with, **options.as_dict()},
        provenance=provenance_of(robot, [m for _, m in problem.placements]),
        checks=problem.checks,
        hypotheses=problem.hypotheses,
        next_placement=problem.next_placement,
        warnings=_warnings(problem, fit),
        outputs={},
        model=_model(robot, calibrated),
        deflection=_deflection(calibrated),
        load=calibrated.load,
        refitted_ball=None if before is None else as_point(before.values),
        folds=tuple(map(_fold_model, problem.folds)),
        data=samples_of(problem, fit.posterior),
        **estimates.posterior_sections(fit, problem),
    )


def _warnings(problem: CalibrationProblem, fit: results.Fit) -> tuple[str, ...]:
    """Return the warnings of a problem, and what its fit does not know."""
    warnings = list(problem.warnings)
    if fit.full is not None and fit.posterior is None:
        warnings.append(UNKNOWN)
    return tuple(warnings)


def _model(robot: Robot, calibrated: results.CalibratedRobot) -> results.Model:
    """Return the nominal and the calibrated model, each as the text of its URDF."""
    return results.Model.filled(
        robot,
        nominal_urdf=robot.text.data.decode(),
        calibrated_urdf=calibrated.urdf().decode(),
    )


def _fold_model(fold: results.Fold) -> results.FoldModel:
    """Return what is kept of a fold's fit."""
    ball = None if fold.ball is None else as_point(fold.ball.values)
    return results.FoldModel.of(fold.fit.calibrated, ball)


def _deflection(
    calibrated: results.CalibratedRobot,
) -> dict[str, tuple[float, ...]]:
    """Return the coefficients of the effects beyond the geometry, by effect."""
    deflection = calibrated.deflection
    pairs = zip(deflection.extensions, deflection.coefficients, strict=True)
    return {name: tuple(values.tolist()) for name, values in pairs}

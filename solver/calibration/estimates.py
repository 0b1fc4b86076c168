"""Estimates of a fit: parameters, error curves, size, and their uncertainty."""

from typing import Any

import numpy as np

from .. import results
from .. import studies as bayes
from ..identification.inference import Posterior
from ..identification.model import ExtendedModel, extend
from .earlier import stored_posterior
from .fit import Fit
from .problem import CalibrationProblem


def parameter_values(
    calibrated: results.CalibratedRobot, posterior: Posterior | None = None
) -> tuple[results.ParameterValue, ...]:
    """Return every calibrated number of the joint origins, with its deviation where known."""
    nominal = calibrated.model.nominal.tolist()
    values = calibrated.values.tolist()
    exported = calibrated.geometry.tolist()
    deviations = [None] * len(values)
    if posterior is not None:
        deviations = bayes.deviations(posterior).tolist()
    parameters: list[results.ParameterValue] = []
    for i, parameter in enumerate(calibrated.parameters):
        value = results.ParameterValue.filled(
            parameter,
            nominal=nominal[i],
            calibrated=values[i],
            change=values[i] - nominal[i],
            exported=exported[i],
            standard_deviation=deviations[i],
        )
        parameters.append(value)
    return tuple(parameters)


def error_curves(posterior: Posterior) -> results.ErrorCurves | None:
    """Return the error curves of the joints that turn, with their deviations; None for none.

    At a knot a cubic B-spline is (c_(k-1) + 4 c_k + c_(k+1)) / 6 of its coefficients c, that go
    round; with B that matrix, the curve is B c, and its covariance B Sigma B^T.
    """
    coefficients = posterior.deflection.curves
    if coefficients is None:
        return None
    model = posterior.model
    group = posterior.groups[-1]
    assert group.length is not None
    knots, m = coefficients.shape
    members = model.slices[-1]
    Sigma = posterior.covariance[members, members]
    identity = np.eye(knots)
    neighbours = np.roll(identity, 1, axis=0) + np.roll(identity, -1, axis=0)
    B = (neighbours + 4 * identity) / 6
    joints: list[results.JointCurve] = []
    for k, joint in enumerate(model.robot.actuated):
        if joint.type == "prismatic":
            continue
        variances = np.sum((B @ Sigma[k::m, k::m]) * B, axis=1)
        positions = posterior.data.q[:, k]
        curve = results.JointCurve(
            joint=joint.name,
            values=_rounded(B @ coefficients[:, k]),
            deviations=_rounded(np.sqrt(variances.clip(min=0))),
            sampled=results.sampled_ranges(positions, group.length),
        )
        joints.append(curve)
    return results.ErrorCurves(
        amplitude=group.width, length=group.length, joints=tuple(joints)
    )


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    """Return angles to a nanoradian, so that a file is not full of digits."""
    return tuple(np.round(values, 9).tolist())


def known_of(
    fit: Fit, problem: CalibrationProblem, before: results.CalibratedRobot | None
) -> dict[str, Any]:
    """Return the document's figures of a posterior by their keys; none without a posterior.

    ``before`` is the nominal robot with its ball refitted, if that is identified.
    """
    posterior = fit.posterior
    selected = fit.selected
    if posterior is None or selected is None:
        return {}
    robot = fit.calibrated.robot
    load = fit.calibrated.load
    held_out = [m for m in problem.test if m.kind == "sockets"]
    held_out_sockets = load.by_socket(robot, *held_out)
    is_alone = fit.world is None
    return {
        "coefficients": _coefficients(posterior),
        "curves": error_curves(posterior),
        "groups": _prior_widths(posterior),
        "noise": _noise_scale(posterior),
        "error_parts": bayes.error_parts(posterior, held_out_sockets),
        "error_patterns": bayes.error_patterns(
            posterior, robot, load, problem.measurements, problem.test
        ),
        "log_evidence": posterior.log_evidence,
        "posterior": stored_posterior(selected.full, problem, alone=is_alone),
        "frames": _frames(fit) or None,
        "better": _better(fit.calibrated, posterior, problem, before),
        "uncertainty": _uncertainty(fit.calibrated, posterior, problem),
    }


def _prior_widths(posterior: Posterior) -> tuple[results.PriorWidth, ...]:
    """Return the groups of parameters, with the widths of their priors."""
    widths: list[results.PriorWidth] = []
    for group in posterior.groups:
        width = results.PriorWidth.filled(
            group,
            count=len(group.members),
            effective=bayes.effective_parameters(posterior, group),
            active=group.width > 0,
        )
        widths.append(width)
    return tuple(widths)


def _noise_scale(posterior: Posterior) -> results.NoiseScale:
    """Return the noise of the samples, and that of an instrument's points and turns."""
    points = posterior.noises.get("points")
    turns = posterior.noises.get("turns")
    return results.NoiseScale.filled(
        posterior.noise,
        measured_space=points and points.space,
        measured_joint=points and points.joint,
        measured_turn=turns and turns.space,
    )


def _better(
    calibrated: results.CalibratedRobot,
    posterior: Posterior,
    problem: CalibrationProblem,
    before: results.CalibratedRobot | None,
) -> results.Better | None:
    """Return the errors of distances before and now."""
    nominal = before or calibrated.with_ball_alone
    is_corrected = calibrated.exported is not None
    models = bayes.Models(
        nominal.ball, calibrated.geometric_ball, corrected=is_corrected
    )
    recorded = [m.positions for _, m in problem.placements]
    return bayes.better_than_nominal(
        posterior, calibrated.load, models, recorded, problem.test
    )


def _uncertainty(
    calibrated: results.CalibratedRobot,
    posterior: Posterior,
    problem: CalibrationProblem,
) -> results.Uncertainty:
    """Return how well the arm is known, and what is not observable."""
    load = calibrated.load
    exported = calibrated.exported
    recorded = [m.positions for _, m in problem.placements]
    weak = bayes.weak_directions(posterior)
    return results.Uncertainty(
        weak_directions=weak,
        correlations=bayes.correlations(posterior),
        observability_index=bayes.observability_index(posterior),
        distance_deviation=bayes.workspace_errors(posterior, load, exported),
        near=bayes.errors_near(posterior, load, recorded, exported),
        cannot_see=bayes.unobservable(posterior, weak),
    )


def _coefficients(posterior: Posterior) -> tuple[results.Coefficient, ...]:
    """Return the coefficients beyond the geometry, but those of curves."""
    model = posterior.model
    deviations = bayes.deviations(posterior).tolist()
    values = posterior.x.tolist()
    coefficients: list[results.Coefficient] = []
    for i in range(model.geometry, model.scalars):
        coefficient = results.Coefficient(
            name=model.names[i],
            unit=model.units[i],
            value=values[i],
            standard_deviation=deviations[i],
        )
        coefficients.append(coefficient)
    return tuple(coefficients)


def _frames(fit: Fit) -> tuple[results.FramePose, ...]:
    """Return the frames of a robot; those of several are results of the first, in its base."""
    assert fit.selected is not None
    if fit.world is None:
        return bayes.frame_poses(fit.selected.full)
    return fit.world.frames if fit.selected.full is fit.world.robots[0].fit else ()


def model_of(fit: Fit) -> tuple[ExtendedModel, np.ndarray]:
    """Return the model of a fit, and its most probable unknowns, shape (size,)."""
    if fit.posterior is not None:
        return fit.posterior.model, fit.posterior.x
    arm = fit.calibrated
    model = extend(arm.robot, arm.parameters, rotation_numbers=arm.rotation_numbers)
    return model, arm.values - arm.model.nominal


def scale_of(fit: Fit) -> results.Scale:
    """Return by how much the arm came out larger than its model."""
    if fit.posterior is not None:
        return bayes.scale(fit.posterior)
    model, x = model_of(fit)
    slopes = model.by_scale()
    value = float(slopes @ x)
    if fit.covariance is None:
        return results.Scale(value=value)
    deviation = float(slopes @ fit.covariance @ slopes) ** 0.5
    return results.Scale(value=value, deviation=deviation)

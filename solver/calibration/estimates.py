"""Estimates of a fit: parameters, error curves, size, and their uncertainty."""

from itertools import chain
from typing import Any

import numpy as np

from .. import results
from ..bayes import results as bayes
from ..bayes.inference import Posterior
from ..bayes.model import ExtendedModel, extend
from .earlier import stored_posterior
from .fit import Fit
from .problem import CalibrationProblem


def parameter_values(
    calibrated: results.CalibratedRobot, posterior: Posterior | None = None
) -> tuple[results.ParameterValue, ...]:
    """Return every calibrated number of the joint origins, with its deviation where known."""
    columns = (calibrated.model.nominal, calibrated.values, calibrated.geometry)
    unknown = [None] * len(calibrated.values)
    deviations = unknown if posterior is None else bayes.deviations(posterior).tolist()
    rows = zip(
        calibrated.parameters, *(c.tolist() for c in columns), deviations, strict=False
    )
    return tuple(
        results.ParameterValue.filled(
            p,
            nominal=a,
            calibrated=b,
            change=b - a,
            exported=c,
            standard_deviation=deviation,
        )
        for p, a, b, c, deviation in rows
    )


def error_curves(posterior: Posterior) -> results.ErrorCurves | None:
    """Return the error curves of the joints that turn, with their deviations; None for none."""
    curves = posterior.deflection.curves
    if curves is None:
        return None
    model = posterior.model
    group = posterior.groups[-1]
    assert group.length is not None
    knots, m = curves.shape
    members = model.slices[-1]
    identity = np.eye(knots)
    at_knots = (
        np.roll(identity, 1, axis=0) + 4 * identity + np.roll(identity, -1, axis=0)
    ) / 6  # cubic B-spline
    joints: list[results.JointCurve] = []
    for k, joint in enumerate(model.robot.actuated):
        if joint.type == "prismatic":
            continue
        sigma = posterior.covariance[members, members][k::m, k::m]
        variances = np.sum((at_knots @ sigma) * at_knots, axis=1)
        joints.append(
            results.JointCurve(
                joint=joint.name,
                values=_rounded(at_knots @ curves[:, k]),
                deviations=_rounded(np.sqrt(variances.clip(min=0))),
                sampled=results.sampled_ranges(
                    posterior.data.positions[:, k], group.length
                ),
            )
        )
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
    calibrated = fit.calibrated
    if posterior is None or selected is None:
        return {}
    load = calibrated.load
    exported = calibrated.exported
    recorded = [m.positions for _, m in problem.placements]
    held = [m for m in problem.test if m.kind == "sockets"]
    measured = posterior.noises.get("points")
    turns = posterior.noises.get("turns")
    nominal = before or calibrated.with_ball_alone
    models = bayes.Models(
        nominal.ball, calibrated.geometric_ball, corrected=exported is not None
    )
    weak = bayes.weak_directions(posterior)
    return {
        "coefficients": _coefficients(posterior),
        "curves": error_curves(posterior),
        "groups": tuple(
            results.PriorWidth.filled(
                group,
                count=len(group.members),
                effective=bayes.effective_parameters(posterior, group),
                active=group.width > 0,
            )
            for group in posterior.groups
        ),
        "noise": results.NoiseScale.filled(
            posterior.noise,
            measured_space=measured and measured.space,
            measured_joint=measured and measured.joint,
            measured_turn=turns and turns.space,
        ),
        "error_parts": bayes.error_parts(
            posterior,
            list(
                chain.from_iterable(load.by_socket(calibrated.robot, m) for m in held)
            ),
        ),
        "error_patterns": bayes.error_patterns(
            posterior, calibrated.robot, load, problem.measurements, problem.test
        ),
        "log_evidence": posterior.log_evidence,
        "posterior": stored_posterior(selected.full, problem, alone=fit.world is None),
        "frames": _frames(fit) or None,
        "better": bayes.better_than_nominal(
            posterior, load, models, recorded, problem.test
        ),
        "uncertainty": results.Uncertainty(
            weak_directions=weak,
            correlations=bayes.correlations(posterior),
            observability_index=bayes.observability_index(posterior),
            distance_deviation=bayes.workspace_errors(posterior, load, exported),
            near=bayes.errors_near(posterior, load, recorded, exported),
            cannot_see=bayes.unobservable(posterior, weak),
        ),
    }


def _coefficients(posterior: Posterior) -> tuple[results.Coefficient, ...]:
    """Return the coefficients beyond the geometry, but those of curves."""
    model = posterior.model
    columns = (
        model.names,
        model.units,
        posterior.x.tolist(),
        bayes.deviations(posterior).tolist(),
    )
    rows = list(zip(*columns, strict=True))[model.geometry : model.scalars]
    return tuple(
        results.Coefficient(
            name=name, unit=unit, value=value, standard_deviation=deviation
        )
        for name, unit, value, deviation in rows
    )


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
    by_scale = model.by_scale()
    value = float(by_scale @ x)
    if fit.covariance is None:
        return results.Scale(value=value)
    return results.Scale(
        value=value, deviation=float(by_scale @ fit.covariance @ by_scale) ** 0.5
    )

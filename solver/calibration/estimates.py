"""Estimates of a fit as its document keeps them: parameters, coefficients, priors and noise."""

from typing import Any

from .. import results
from ..identification.inference import Posterior
from .problem import CalibrationProblem
from .stored_posterior import stored_posterior


def parameter_values(
    calibrated: results.CalibratedRobot,
) -> tuple[results.ParameterValue, ...]:
    """Return every calibrated number of the joint origins."""
    nominal = calibrated.model.nominal.tolist()
    values = calibrated.values.tolist()
    exported = calibrated.geometry.tolist()
    parameters: list[results.ParameterValue] = []
    for i, parameter in enumerate(calibrated.parameters):
        value = results.ParameterValue.filled(
            parameter,
            nominal=nominal[i],
            calibrated=values[i],
            change=values[i] - nominal[i],
            exported=exported[i],
            standard_deviation=None,
        )
        parameters.append(value)
    return tuple(parameters)


def posterior_sections(fit: results.Fit, problem: CalibrationProblem) -> dict[str, Any]:
    """Return the sections that a posterior is stored in; none without a posterior."""
    posterior = fit.posterior
    if posterior is None or fit.full is None:
        return {}
    alone = fit.frames is None
    return {
        "coefficients": _coefficients(posterior),
        "groups": _prior_widths(posterior),
        "noise": _noise_scale(posterior),
        "log_evidence": posterior.log_evidence,
        "posterior": stored_posterior(fit.full, problem, alone=alone),
    }


def _prior_widths(posterior: Posterior) -> tuple[results.PriorWidth, ...]:
    """Return the groups of parameters, with the widths of their priors."""
    widths: list[results.PriorWidth] = []
    for group in posterior.groups:
        width = results.PriorWidth.filled(
            group,
            count=len(group.members),
            effective=group.effective,
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


def _coefficients(posterior: Posterior) -> tuple[results.Coefficient, ...]:
    """Return the coefficients beyond the geometry, but those of curves."""
    model = posterior.model
    values = posterior.x.tolist()
    coefficients: list[results.Coefficient] = []
    for i in range(model.geometry, model.scalars):
        coefficient = results.Coefficient(
            name=model.names[i],
            unit=model.units[i],
            value=values[i],
            standard_deviation=posterior.covariance[i, i] ** 0.5,
        )
        coefficients.append(coefficient)
    return tuple(coefficients)

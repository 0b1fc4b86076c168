"""Study: by how much the arm came out larger than its model."""

import numpy as np

from ..identification.model import ExtendedModel, extend
from ..results import Fit, Measurements, Scale, Study
from .uncertainty import scale


def model_of(fit: Fit) -> tuple[ExtendedModel, np.ndarray]:
    """Return the model of a fit, and its most probable unknowns, shape (size,)."""
    if fit.posterior is not None:
        return fit.posterior.model, fit.posterior.x
    arm = fit.calibrated
    model = extend(arm.robot, arm.parameters, rotation_numbers=arm.rotation_numbers)
    return model, arm.values - arm.model.nominal


def scale_of(
    fit: Fit,
    _: Measurements,
) -> Scale:
    """Return by how much the arm came out larger than its model."""
    if fit.posterior is not None:
        return scale(fit.posterior)
    model, x = model_of(fit)
    slopes = model.by_scale()
    value = float(slopes @ x)
    if fit.covariance is None:
        return Scale(value=value)
    deviation = float(slopes @ fit.covariance @ slopes) ** 0.5
    return Scale(value=value, deviation=deviation)


SCALE = Study("scale", scale_of, needs_posterior=False)

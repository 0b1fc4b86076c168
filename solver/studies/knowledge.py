"""Study: how well the arm is known, and what is not observable."""

from ..results import Fit, Measurements, Study, Uncertainty
from .identifiability import unobservable, weak_directions
from .predicted_errors import errors_near, workspace_errors
from .uncertainty import correlations, observability_index


def uncertainty(fit: Fit, measurements: Measurements) -> Uncertainty:
    """Return how well the arm is known, and what is not observable."""
    posterior = fit.posterior
    assert posterior is not None
    load = fit.calibrated.load
    exported = fit.calibrated.exported
    recorded = [m for _, m in measurements.placements]
    weak = weak_directions(posterior)
    return Uncertainty(
        weak_directions=weak,
        correlations=correlations(posterior),
        observability_index=observability_index(posterior),
        distance_deviation=workspace_errors(posterior, load, exported),
        near=errors_near(posterior, load, recorded, exported),
        cannot_see=unobservable(posterior, weak),
    )


UNCERTAINTY = Study("uncertainty", uncertainty)

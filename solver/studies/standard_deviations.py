"""Study: standard deviations of the unknowns, and how many of each group the data decide."""

from collections.abc import Sequence

from msgspec import structs

from ..results import Coefficient, Fit, Measurements, ParameterValue, PriorWidth, Study
from .uncertainty import deviations, effective_parameters


def parameters(
    fit: Fit, _: Measurements, values: Sequence[ParameterValue]
) -> tuple[ParameterValue, ...]:
    """Return every calibrated number of the joint origins with its standard deviation."""
    assert fit.posterior is not None
    pairs = zip(values, deviations(fit.posterior).tolist(), strict=False)
    return tuple(structs.replace(v, standard_deviation=s) for v, s in pairs)


def coefficients(
    fit: Fit, _: Measurements, values: Sequence[Coefficient]
) -> tuple[Coefficient, ...]:
    """Return the coefficients beyond the geometry with their standard deviations."""
    assert fit.posterior is not None
    begin = fit.posterior.model.geometry
    pairs = zip(values, deviations(fit.posterior)[begin:].tolist(), strict=False)
    return tuple(structs.replace(v, standard_deviation=s) for v, s in pairs)


def groups(
    fit: Fit, _: Measurements, widths: Sequence[PriorWidth]
) -> tuple[PriorWidth, ...]:
    """Return the widths of the priors with how many of their unknowns the data decide."""
    posterior = fit.posterior
    assert posterior is not None
    counts = [effective_parameters(posterior, group) for group in posterior.groups]
    pairs = zip(widths, counts, strict=True)
    return tuple(structs.replace(w, effective=count) for w, count in pairs)


PARAMETERS = Study("parameters", parameters, ("parameters",))
COEFFICIENTS = Study("coefficients", coefficients, ("coefficients",))
GROUPS = Study("groups", groups, ("groups",))

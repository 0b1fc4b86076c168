"""What a fit found, parameter by parameter, and how well it is known."""

from ..bayes.inference import Posterior
from ..bayes.model import extend
from ..bayes.results import uncertainty, unobservable, weakly_identifiable_directions
from ..data import Load
from ..results import (
    CalibratedRobot,
    Coefficient,
    Correlation,
    DistanceDeviation,
    NoiseScale,
    ParameterValue,
    PriorWidth,
    Scale,
    Uncertainty,
)
from .fit import Fit


def parameter_values(
    calibrated: CalibratedRobot, posterior: Posterior | None = None
) -> tuple[ParameterValue, ...]:
    """Return every calibrated number of the joint origins, with its deviation where known."""
    values = calibrated.values
    exported = values if calibrated.exported is None else calibrated.exported
    deviations = None if posterior is None else uncertainty.deviations(posterior)
    return tuple(
        ParameterValue(
            name=p.name,
            joint=p.joint,
            component=p.component,
            unit=p.unit,
            nominal=float(nominal),
            calibrated=float(values[i]),
            change=float(values[i] - nominal),
            exported=float(exported[i]),
            standard_deviation=None if deviations is None else float(deviations[i]),
        )
        for i, (p, nominal) in enumerate(
            zip(calibrated.parameters, calibrated.model.nominal, strict=True)
        )
    )


def coefficient_values(posterior: Posterior) -> tuple[Coefficient, ...]:
    """Return the coefficients of the extensions, with their deviations."""
    model = posterior.model
    deviations = uncertainty.deviations(posterior)
    rows = list(zip(model.names, model.units, posterior.x, deviations, strict=True))
    return tuple(
        Coefficient(name=name, unit=unit, value=float(value), standard_deviation=float(deviation))
        for name, unit, value, deviation in rows[model.geometry :]
    )


def prior_widths(posterior: Posterior) -> tuple[PriorWidth, ...]:
    """Return the groups of unknowns, and what the data decided of their priors."""
    return tuple(
        PriorWidth(
            name=group.name,
            unit=group.unit,
            count=len(group.members),
            width=group.width,
            effective=uncertainty.effective_parameters(posterior, group),
            active=group.width > 0,
        )
        for group in posterior.groups
    )


def noise_scale(posterior: Posterior) -> NoiseScale:
    """Return the noise that was found."""
    noise, measured = posterior.noise, posterior.measured_noise
    return NoiseScale(
        space=noise.space,
        joint=noise.joint,
        nu=noise.nu,
        measured_space=None if measured is None else measured.space,
        measured_joint=None if measured is None else measured.joint,
    )


def uncertainty_of(posterior: Posterior, load: Load) -> Uncertainty:
    """Return how well the calibration is known, and what the data cannot tell."""
    median, worst, length = uncertainty.workspace_deviation(posterior, load)
    weak = tuple(weakly_identifiable_directions(posterior))
    return Uncertainty(
        weak_directions=weak,
        correlations=tuple(
            Correlation(a=a, b=b, value=r) for a, b, r in uncertainty.correlations(posterior)
        ),
        observability_index=uncertainty.observability_index(posterior),
        distance_deviation=DistanceDeviation(median=median, worst=worst, length=length),
        cannot_see=unobservable(posterior, weak),
    )


def scale_of(fit: Fit) -> Scale:
    """Return by how much the arm came out larger than its model."""
    if fit.posterior is not None:
        value, deviation = uncertainty.scale(fit.posterior)
        return Scale(value=value, deviation=deviation)
    calibrated = fit.calibrated
    by_scale = extend(calibrated.robot, calibrated.parameters).by_scale()
    value = float(by_scale @ (calibrated.values - calibrated.model.nominal))
    if fit.covariance is None:
        return Scale(value=value)
    return Scale(value=value, deviation=float(by_scale @ fit.covariance @ by_scale) ** 0.5)

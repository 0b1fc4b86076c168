"""The two views that turn under the mouse; the page's script draws them from the figures."""

from ....solver.assessment import ModelName, mm, nice_above, plural
from ..figures import ReportDocument
from .plot import BOTH, HOLLOW, Plot, lengths
from .samples import FINE


def errors_in_3d(report: ReportDocument) -> Plot:
    """Every sample round its socket, nominal and calibrated side by side, to one scale."""
    nominal, calibrated = _largest(report, "nominal"), _largest(report, "calibrated")
    limit = report.limits.mean_absolute_error.value
    ring = f"; the dashed ring is the limit of {mm(limit)} on the mean" if limit else ""
    half = nice_above(max(nominal, calibrated, 1e-6), FINE)
    return Plot(
        "errors-3d",
        "The error of every sample, in space",
        f"Both boxes are {2e3 * half:g} mm wide: the farthest of {len(report.samples)} samples "
        f"is {mm(nominal)} from its socket's centre by the nominal model and "
        f"{mm(calibrated)} by the calibrated one{ring}.",
        legend=(*BOTH, HOLLOW),
        layout="scenes",
        scene="errors",
        controls={"placements": [(i, row.name) for i, row in enumerate(report.placements)]},
    )


def _largest(report: ReportDocument, model: ModelName) -> float:
    """Return the error of the farthest sample [m]."""
    return float(lengths(report, model).max(initial=0.0))


def arm_in_3d(report: ReportDocument) -> Plot:
    """The arm in its recorded configurations, nominal against calibrated."""
    arm = report.arm
    count, factor = len(arm.placements), arm.exaggeration
    shown = f"drawn {factor:g} times as large at first" if factor > 1 else "drawn as it is"
    factors = sorted({1.0, factor, 10 * factor})
    return Plot(
        "arm-3d",
        "The arm as it stood",
        f"In {plural(count, 'recorded configuration')} the two models put the ball "
        f"{mm(arm.displacement.mean)} apart on average and {mm(arm.displacement.max)} "
        f"at most, {shown}.",
        legend=(*BOTH, ("socket-key", "sockets")),
        layout="scenes one",
        scene="arm",
        controls={
            "configurations": count,
            "factor": factor,
            "factors": [(k, f"{k:g} x" if k != 1 else "true") for k in factors],
        },
    )

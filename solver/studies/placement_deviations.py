"""Study: how large the errors at each placement should be by the posterior."""

from collections.abc import Sequence
from dataclasses import replace

from msgspec import structs

from ..identification.data import Measurement, found_deviation
from ..identification.inference import Posterior
from ..results import CalibratedRobot, Fit, Measurements, PlacementErrors, Study
from .base_errors import BaseErrors, length_deviation
from .base_length import BaseLength
from .held_out_misfit import HeldOut, misfit
from .uncertainty import predicted_deviation


def placements(
    fit: Fit, measurements: Measurements, rows: Sequence[PlacementErrors]
) -> tuple[PlacementErrors, ...]:
    """Return the errors of all placements, and how large they should be."""
    assert fit.posterior is not None
    expected: list[PlacementErrors] = []
    for (role, m), row in zip(measurements.placements, rows, strict=True):
        deviations = _deviations(
            fit.calibrated, fit.posterior, m, held_out=role == "test"
        )
        expected.append(structs.replace(row, **deviations))
    return tuple(expected)


def left_out(
    _: Fit, measurements: Measurements, rows: Sequence[PlacementErrors]
) -> tuple[PlacementErrors, ...]:
    """Return the errors of what folds leave out, and how large they should be by the fold."""
    parts = [(fold.fit, m) for fold in measurements.folds for m in fold.left_out]
    expected: list[PlacementErrors] = []
    for (fit, m), row in zip(parts, rows, strict=True):
        if fit.posterior is not None:
            deviations = _deviations(fit.calibrated, fit.posterior, m, held_out=True)
            row = structs.replace(row, **deviations)
        expected.append(row)
    return tuple(expected)


def misfit_of_folds(fit: Fit, measurements: Measurements) -> float | None:
    """Return f by what folds leave out; None without folds."""
    if not measurements.folds:
        return None
    robot, load = measurements.robot, fit.calibrated.load
    places: list[tuple[Posterior, HeldOut]] = []
    for posterior, placements in measurements.unseen(fit):
        for measured in placements:
            held_out = HeldOut.of(robot, load, measured)
            places += [(posterior, place) for place in held_out]
    return misfit(places)


def _deviations(
    calibrated: CalibratedRobot,
    posterior: Posterior,
    measured: Measurement,
    *,
    held_out: bool,
) -> dict[str, float]:
    """Return rms distances of samples from their socket's mean, and that of a distance held out."""
    points = calibrated.predict(measured)
    if measured.kind == "points":
        noises = {"sockets": posterior.noises.get("points", posterior.noise)}
        posterior = replace(posterior, noises=noises)
    by_socket = calibrated.load.by_socket(calibrated.robot, measured)
    deviations = {
        "predicted_deviation": predicted_deviation(posterior, by_socket),
        "found_deviation": found_deviation(points, measured),
    }
    if held_out and measured.has_distance:
        bases = BaseErrors.of(posterior, [measured])
        length = BaseLength.at(posterior, by_socket)
        deviations["distance_deviation"] = length_deviation(bases, length, measured)
    return deviations


PLACEMENTS = Study("placements", placements, ("placements",))
LEFT_OUT = Study("left_out", left_out, ("left_out",))
MISFIT = Study("misfit", misfit_of_folds)

"""Inspection of recordings before they are fitted: each placement, and all of them together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import CALIPER_DEVIATION, KnownDistance, Measurement
from ..robot import Robot
from .change_points import Change
from .checks import FIT_CHECKS, RECORDING_CHECKS
from .columns import column_behind_scale, column_diagnostics
from .diagnostic import Diagnostic
from .distances import DistanceVerdict, Scale, check_distances, named
from .evidence import Evidence, gather
from .robust_fit import UNEXPLAINED, RigidFit


@dataclass(frozen=True)
class Inspection:
    """Diagnostics of one placement."""

    measured: Measurement
    floor: float
    """Mean error of a fit to this placement alone, see :func:`.fit_error.fitted_alone` [m]."""
    changes: tuple[Change, ...]
    """Moves of its base."""
    diagnostics: tuple[Diagnostic, ...]
    centre: np.ndarray
    """Between its sockets, as the fit to all placements predicts it, shape (3,) [m]."""

    @property
    def sound(self) -> bool:
        """True where nothing has to be mended before it is trained on."""
        return all(diagnostic.level != "error" for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class Survey:
    """Diagnostics of several placements, and the size of the arm by them."""

    placements: tuple[Inspection, ...]
    shared: tuple[Diagnostic, ...]
    """Diagnostics of all placements, or of the arm."""
    scale: Scale | None
    """The arm's size by known distances; None where none is known."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics, those of all placements first."""
        return (*self.shared, *(d for one in self.placements for d in one.diagnostics))


def inspect_all(
    robot: Robot,
    measurements: Sequence[Measurement],
    *,
    known: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
    zeros: bool = False,
) -> Survey:
    """Inspect placements: each by itself, and all together.

    Args:
        robot: The robot.
        measurements: The placements; those that an instrument measured are passed over.
        known: Distances measured beside those between each placement's sockets.
        deviation: Standard deviation of the latter [m].
        zeros: The joints may have offsets of degrees, as on arms made of servos: then that is no
            mistake.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    seated = [m for m in measurements if m.kind == "sockets"]
    known = named(seated, known)
    if not seated:
        return Survey((), (), None)
    evidence = gather(robot, seated, known=known, deviation=deviation, zeros=zeros)
    columns = _check_columns(evidence)
    # A mistake in all columns shows as anything: told first, and alone.
    explained = any(diagnostic.level == "error" for diagnostic in columns)
    distances = _check_distances(evidence, evidence.together)
    if distances.doubts_scale and not explained:
        behind = column_behind_scale(evidence.model, evidence.good)
        if behind is not None:
            columns = [*columns, behind[0]]
            distances = _check_distances(evidence, behind[1])
    inspections = tuple(
        _inspect(evidence, m, None if explained else distances) for m in evidence.measurements
    )
    loose = any(evidence.explained_by_backlash(c) for m in evidence.good for c in evidence.moves(m))
    # Backlash makes an arm seem longer or shorter: it is told first, and then what is left.
    sizes = [d for d in distances.shared if not (loose and d.code == "scale")]
    return Survey(inspections, (*columns, *([] if explained else sizes)), distances.scale)


def _check_columns(evidence: Evidence) -> list[Diagnostic]:
    """Return mistakes in the columns of all placements."""
    fit = evidence.together
    displaced = any(evidence.displacements(m) for m in evidence.good)
    apart = fit.samples if displaced and fit.error < UNEXPLAINED else None
    return column_diagnostics(evidence.model, evidence.good, apart)


def _check_distances(evidence: Evidence, fit: RigidFit) -> DistanceVerdict:
    """Compare the distances that are known with a fit's."""
    good = evidence.good
    names = {m.name for m in good}
    moved = [m.name for m in good if evidence.moves(m)]
    usable = [k for k in evidence.known if {k.first[0], k.second[0]} <= names]
    return check_distances(good, fit, moved, usable, evidence.deviation)


def _inspect(
    evidence: Evidence, measured: Measurement, distances: DistanceVerdict | None
) -> Inspection:
    """Inspect one placement; without distances where wrong columns explain all that a fit shows."""
    name = measured.name
    found = list(evidence.bad[name])
    changes: tuple[Change, ...] = ()
    if distances is not None and not found:
        changes = evidence.moves(measured)
        found += [d for check in FIT_CHECKS for d in check(evidence, measured)]
        found += [distances.single[name]] if name in distances.single else []
    found += [d for check in RECORDING_CHECKS for d in check(evidence, measured)]
    ball = evidence.model.ball
    points = ball.points(ball.nominal + evidence.together.x, measured.positions)
    centre = np.mean([np.median(points[rows], axis=0) for rows in measured.slices], axis=0)
    return Inspection(measured, evidence.alone[name][0].error, changes, tuple(found), centre)

"""A look at the data before they are fitted: what a person would want to know at once.

Quick fits, of each placement alone and of all together, show bases that moved, samples in another
socket or far away, a wrong distance between the sockets, and columns with a wrong sign, order or
zero; the joint positions show near-duplicates and joints that stood still. No fit here believes
the sockets' distance, and none can fail to settle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import CALIPER_DEVIATION, KnownDistance, Measurement
from ..robot import Parameter, Robot, choose_parameters
from .advice import place_advice
from .change_points import Change, find_parts
from .columns import UNEXPLAINED, column_findings, columns_behind
from .configurations import duplicate_findings, still_findings
from .diagnostic import Diagnostic, where_of
from .distances import Scale, judge_distances, named
from .robust_fit import RigidModel, samples_of
from .sample_count import few_findings
from .socket_outliers import Sockets, elsewhere, explained_by_backlash, far_samples

BAD_FLOOR = 2.5
"""A placement is not to be trusted if the fit to it alone leaves this many times the error that is
usual for the others."""
EXACT = 1e-5
"""What the fit leaves of fewer samples than it has unknowns, at most [m]: it says nothing."""


@dataclass(frozen=True)
class Inspection:
    """What one placement shows by itself."""

    measured: Measurement
    floor: float
    """Mean error of a fit to this placement alone, see :func:`fitted_alone` [m]."""
    changes: tuple[Change, ...]
    findings: tuple[Diagnostic, ...]
    centre: np.ndarray
    """Between its sockets, as the fit to all placements predicts it, shape (3,) [m]."""

    @property
    def sound(self) -> bool:
        """Whether nothing has to be mended before it is trained on."""
        return all(finding.level != "error" for finding in self.findings)


@dataclass(frozen=True)
class Survey:
    """What recordings show before they are fitted."""

    placements: tuple[Inspection, ...]
    shared: tuple[Diagnostic, ...]
    """What concerns all placements, or the arm."""
    scale: Scale | None
    """What the distances say of the arm's size; None where none is known."""

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        """All findings, those on all placements first."""
        return (*self.shared, *(f for one in self.placements for f in one.findings))


def inspect_all(
    robot: Robot,
    parameters: Sequence[Parameter],
    measurements: Sequence[Measurement],
    *,
    known: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
    zeros: bool = False,
) -> Survey:
    """Inspect placements: each fitted alone, and all together to see whether a base moved.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        measurements: The placements; those that an instrument measured are passed over.
        known: Distances measured beside those between each placement's sockets.
        deviation: Standard deviation of the latter [m].
        zeros: Whether the joints' zeros may be off by degrees, as on arms made of servos: then
            that is no mistake.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    measurements = [m for m in measurements if m.kind == "sockets"]
    known = named(measurements, known)
    if not measurements:
        return Survey((), (), None)
    model = RigidModel(robot, parameters, zeros=zeros)
    alone = {m.name: find_parts(model, samples_of([m])) for m in measurements}
    floors = [fit.error for fit, _ in alone.values()]
    bad = {
        m.name: [] if typical is None else _bad(model, m, floor, typical)
        for m, floor, typical in zip(measurements, floors, standing_out(floors), strict=True)
    }
    good = [m for m in measurements if not bad[m.name]]
    together, parts = alone[good[0].name] if len(good) == 1 else find_parts(model, samples_of(good))
    labels = tuple((m.name, socket) for m in good for socket in m.sockets)
    sockets = Sockets(labels, together.centres[: len(labels)], together.noise)
    placed = {m.name: elsewhere(m, parts, together, sockets, zeros=zeros) for m in good}
    apart = together.error < UNEXPLAINED and any(findings for findings, _ in placed.values())
    columns = column_findings(model, good, together.samples if apart else None)
    # A mistake in all columns shows as anything: told first, and alone.
    explained = any(finding.level == "error" for finding in columns)
    moved = [name for name, (_, changes) in placed.items() if changes]
    kept = {m.name for m in good}
    usable = [k for k in known if {k.first[0], k.second[0]} <= kept]
    distances = judge_distances(good, together, moved, usable, deviation)
    behind = columns_behind(model, good) if distances.size and not explained else None
    if behind is not None:
        columns = [*columns, behind[0]]
        distances = judge_distances(good, behind[1], moved, usable, deviation)
    inspections: list[Inspection] = []
    for i, measured in enumerate(measurements):
        changes: tuple[Change, ...] = ()
        findings = bad[measured.name]
        if not explained and not findings:
            findings, changes = placed[measured.name]
            fit, own = alone[measured.name]
            findings += far_samples(measured, own, fit, sockets)
            findings += (
                [distances.single[measured.name]] if measured.name in distances.single else []
            )
        findings = [
            *findings,
            *few_findings(measured),
            *duplicate_findings(measured),
            *still_findings(measured, robot),
        ]
        points = model.ball.points(model.ball.nominal + together.x, measured.positions)
        centre = np.mean([np.median(points[rows], axis=0) for rows in measured.slices], axis=0)
        inspections.append(Inspection(measured, floors[i], changes, tuple(findings), centre))
    moves = [move for _, own in placed.values() for move in own]
    loose = not zeros and any(explained_by_backlash(sockets, move) for move in moves)
    # Play makes an arm seem longer or shorter: it is told first, and then what is left.
    sizes = [f for f in distances.shared if not (loose and f.code == "scale")]
    shared = columns if explained else [*columns, *sizes]
    return Survey(tuple(inspections), tuple(shared), distances.scale)


def fitted_alone(robot: Robot, measurements: Sequence[Measurement]) -> dict[str, float]:
    """Return what each placement leaves when fitted alone, by its name [m].

    It is the mean distance of its samples from their socket, each by its weight, by a robust
    rigid fit to nothing but them, parts apart where the base moved.
    """
    model = RigidModel(robot, choose_parameters(robot))
    return {m.name: find_parts(model, samples_of([m]))[0].error for m in measurements}


def standing_out(floors: Sequence[float]) -> list[float | None]:
    """Return, for each placement that stands out, what it should leave by the others [m].

    Args:
        floors: What each leaves when fitted alone [m].

    Returns:
        None for each that leaves about as much as the others.
    """
    typical = [_typical([*floors[:i], *floors[i + 1 :]]) for i in range(len(floors))]
    return [
        t if f > BAD_FLOOR * max(t, EXACT) else None for f, t in zip(floors, typical, strict=True)
    ]


def next_placement(robot: Robot, survey: Survey) -> str:
    """Return which placements to train on, and where to record the next one."""
    inspections = survey.placements
    mistaken = any(finding.level == "error" for finding in survey.shared)
    return place_advice(
        robot,
        [one.measured.name for one in inspections],
        np.array([one.centre for one in inspections]),
        [one.sound and not mistaken for one in inspections],
    )


def _typical(others: Sequence[float]) -> float:
    """Return the error that a placement should leave by those that others leave [m].

    Infinity where they do not tell: there are none, or no better.
    """
    typical = float(np.median(others)) if others else np.inf
    if len(others) == 1:
        typical = max(typical, UNEXPLAINED / BAD_FLOOR)
    return typical if typical < UNEXPLAINED else np.inf


def _bad(
    model: RigidModel, measured: Measurement, floor: float, typical: float
) -> list[Diagnostic]:
    """Return why a placement alone leaves much more than the others do, if columns tell."""
    columns = [f for f in column_findings(model, [measured]) if f.level == "error"]
    if any(finding.code != "model" for finding in columns):
        return columns
    return [
        Diagnostic(
            "error",
            "floor",
            where_of([measured]),
            f"fitted alone it leaves {1e3 * floor:.2f} mm, the others {1e3 * typical:.2f} mm",
            "no model explains it: record it again, or leave it out",
        )
    ]

"""Checks of the joint positions alone: too few, near-duplicates, and joints that stood still."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from ..data import KnownDistance, Measurement
from ..results import Diagnostic
from ..robot import Robot
from .distances import named
from .hypothesis import row_of, where_of

NEAR = np.deg2rad(1.0)
"""Two configurations closer than this on every joint are nearly the same."""
LISTED = 5
"""Near-duplicates of a socket that are named one by one."""
STILL = np.deg2rad(5.0)
"""A joint that moved less than this in a placement tells hardly anything."""
FEWEST, ADVISED = 10, 30
"""Samples in a socket below which it tells little, and that are advised."""


def duplicates(_: Robot, measured: Measurement) -> list[Diagnostic]:
    """Return samples that are nearly the configuration of one before, in the same socket."""
    found: list[Diagnostic] = []
    for socket, rows in zip(measured.sockets, measured.by_socket, strict=True):
        twins = near_duplicates(rows)
        more = f", one of {len(twins)} such" if len(twins) > LISTED else ""
        found += [
            Diagnostic(
                "warning",
                "duplicate",
                row_of(measured, socket, later),
                f"nearly the configuration of sample {first + 1} of socket {socket}{more}",
                "it adds little: guide the arm to other configurations",
            )
            for later, first in list(twins.items())[:LISTED]
        ]
    return found


def near_duplicates(rows: np.ndarray) -> dict[int, int]:
    """Return each row that is nearly one before it, with the first such row; cells keep it fast."""
    widest = np.argsort(-np.ptp(rows, axis=0))[:3]
    places = rows[:, widest] / (2 * NEAR)
    cells = np.floor(places)
    sides = np.where(places - cells < 0.5, -1, 1)
    members: dict[tuple[float, ...], list[int]] = {}
    nearest: dict[int, int] = {}
    steps = np.array(list(product((0, 1), repeat=len(widest))))
    for i in range(len(rows)):
        around = cells[i] + steps * sides[i]
        others = sorted(k for cell in map(tuple, around.tolist()) for k in members.get(cell, ()))
        near = np.abs(rows[others] - rows[i]).max(axis=1) < NEAR if others else np.zeros(1)
        if near.any():
            nearest[i] = others[int(np.argmax(near))]
        else:
            members.setdefault(tuple(cells[i].tolist()), []).append(i)
    return nearest


def motionless_joints(robot: Robot, measured: Measurement) -> list[Diagnostic]:
    """Return joints that hardly moved in a placement."""
    travels = np.ptp(measured.positions, axis=0).tolist()
    return [
        Diagnostic(
            "warning",
            "still",
            where_of([measured]),
            f"joint {joint.name!r} "
            + (
                "did not move at all"
                if travel < 1e-9
                else f"moved by {np.rad2deg(travel):.1f} deg only"
            ),
            "its parameters stay near nominal: move every joint by 60 deg or more",
        )
        for joint, travel in zip(robot.actuated, travels, strict=True)
        if travel < STILL
    ]


def few_samples(_: Robot, measured: Measurement) -> list[Diagnostic]:
    """Return sockets of a placement with too few samples."""
    return [
        Diagnostic(
            "warning",
            "few",
            where_of([measured]),
            f"{count} samples in socket {socket}",
            f"record {ADVISED - count} more: {ADVISED} are advised, {FEWEST} are the least",
        )
        for socket, count in zip(measured.sockets, measured.counts, strict=True)
        if count < FEWEST
    ]


def single_socket_diagnostics(
    measurements: Sequence[Measurement], known: Sequence[KnownDistance] = ()
) -> list[Diagnostic]:
    """Return placements with one socket, which no known distance ties to a length."""
    whole = named(measurements, known)
    scaled = {name for k in whole for name, _ in (k.first, k.second)}
    return [
        Diagnostic(
            "error",
            "lone",
            where_of([m]),
            f"only socket {m.sockets[0]} has samples, so solve refuses it",
            "record the other socket too, or tie it by a known distance, solve --known",
        )
        for m in measurements
        if m.kind == "sockets" and not m.has_distance and m.name not in scaled
    ]

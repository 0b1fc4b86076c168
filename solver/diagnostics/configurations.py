"""What joint positions alone tell of a recording: near-duplicates, and joints that stood still."""

from itertools import product

import numpy as np

from ..data import Measurement
from ..robot import Robot
from .diagnostic import Diagnostic, row_of, where_of

NEAR = np.deg2rad(1.0)
"""Two configurations closer than this on every joint are nearly the same."""
LISTED = 5
"""Near-duplicates of a socket that are named one by one."""
STILL = np.deg2rad(5.0)
"""A joint that moved less than this in a placement tells hardly anything."""


def duplicate_findings(measured: Measurement) -> list[Diagnostic]:
    """Return samples that are nearly the configuration of one before, in the same socket."""
    findings: list[Diagnostic] = []
    for socket, rows in zip(measured.sockets, measured.by_socket, strict=True):
        twins = near_duplicates(rows)
        for later, first in list(twins.items())[:LISTED]:
            more = f", one of {len(twins)} such" if len(twins) > LISTED else ""
            findings.append(
                Diagnostic(
                    "warning",
                    "duplicate",
                    row_of(measured, socket, later),
                    f"nearly the configuration of sample {first + 1} of socket {socket}{more}",
                    "it adds little: guide the arm to other configurations",
                )
            )
    return findings


def near_duplicates(rows: np.ndarray) -> dict[int, int]:
    """Return each row that is nearly one before it, with the first such row.

    Rows are sorted into cells twice as wide as what counts as near, by the joints that move most,
    so that a row is compared only with those of its cell and of the cells on its nearer sides.
    """
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


def still_findings(measured: Measurement, robot: Robot) -> list[Diagnostic]:
    """Return joints that hardly moved in a placement."""
    findings: list[Diagnostic] = []
    for k, joint in enumerate(robot.actuated):
        travel = float(np.ptp(measured.positions[:, k]))
        if travel < STILL:
            how = (
                "did not move at all"
                if travel < 1e-9
                else f"moved by {np.rad2deg(travel):.1f} deg only"
            )
            findings.append(
                Diagnostic(
                    "warning",
                    "still",
                    where_of([measured]),
                    f"joint {joint.name!r} {how}",
                    "its parameters stay near nominal: move every joint by 60 deg or more",
                )
            )
    return findings

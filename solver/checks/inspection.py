"""A look at the data before they are fitted: what a person would want to know at once.

Each placement is fitted alone, robustly, and its residuals are searched for a base that moved, for
samples far from their socket, and for sockets mixed up; its joint positions for near-duplicates
and for joints that stood still.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np

from ..auto.estimation import estimate
from ..auto.extended_model import extend
from ..auto.posterior import Posterior
from ..data.measurements import Measurement
from ..data.observations import Load, observe
from ..robot.parameters import Parameter
from ..robot.urdf import Robot
from .changes import Change, find_changes

__all__ = [
    "Finding",
    "Inspection",
    "farthest_place",
    "inspect_all",
    "next_placement",
]

NEAR = np.deg2rad(1.0)
"""Two configurations closer than this on every joint are nearly the same."""
STILL = np.deg2rad(5.0)
"""A joint that moved less than this in a placement tells hardly anything."""
FAR = 0.06
"""Robust weight below which a sample is far from its socket, about 9 deviations."""
BAD_FLOOR = 2.5
"""A placement is not to be trusted if its error, fitted alone, is this many times the others'."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or may be, in a recording."""

    level: str
    """``error``: do not train on it as it is; ``warning``: look at it."""
    code: str
    where: str
    text: str
    advice: str

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.where}: {self.text}; {self.advice}"


@dataclass(frozen=True)
class Inspection:
    """What was found out about one placement."""

    measured: Measurement
    floor: float
    """Mean distance of the samples from their socket's centre in a fit to this placement alone [m];
    the error that no model gets rid of. Samples far off weigh little."""
    changes: tuple[Change, ...]
    findings: tuple[Finding, ...]
    centre: np.ndarray
    """Between its sockets, as the fit to all placements predicts it, shape (3,) [m]."""


def inspect_all(
    robot: Robot,
    parameters: Sequence[Parameter],
    measurements: Sequence[Measurement],
    load: Load | None = None,
) -> list[Inspection]:
    """Inspect placements: each fitted alone, and all together to see whether a base moved.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        measurements: The placements.
        load: What pulls at the joints; None for gravity alone, straight down.

    Raises:
        NotConverged: A fit did not settle.
    """
    alone = [_fit(robot, parameters, [measured], load) for measured in measurements]
    together = _fit(robot, parameters, measurements, load) if len(alone) > 1 else alone[0]
    floors = [_floor(fitted) for fitted in alone]
    seen: list[Inspection] = []
    for i, measured in enumerate(measurements):
        changes = find_changes(measured, together)
        findings = [
            *_moved(measured, changes),
            *_bad_floor(measured, floors[i], floors[:i] + floors[i + 1 :]),
            *_far(measured, alone[i], changes),
            *_duplicates(measured),
            *_still(measured, robot),
        ]
        labels = together.data.labels
        rows = [k for k, (name, _) in enumerate(labels) if name == measured.name]
        centre = together.centres[rows].mean(axis=0)
        seen.append(Inspection(measured, floors[i], changes, tuple(findings), centre))
    return seen


def next_placement(robot: Robot, seen: Sequence[Inspection]) -> str:
    """Return which placements to train on, and where to record the next one.

    The two most distant placements serve best (paper, Fig. 6).
    """
    centres = np.array([one.centre for one in seen])
    x, y, z = place = farthest_place(centres)
    gap = float(np.linalg.norm(centres - place, axis=1).min())
    side = "left" if y > 0.1 * np.hypot(x, y) else "right" if y < -0.1 * np.hypot(x, y) else "front"
    hint = (
        f"Next, record a placement near x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m in the frame of "
        f"{robot.base} (to its {side}), {gap:.2f} m from the nearest so far, or as far that "
        "way as the arm reaches."
    )
    if len(seen) < 2:
        return hint
    apart = np.linalg.norm(centres[:, None] - centres, axis=2)
    i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
    best = f"{seen[int(i)].measured.name} and {seen[int(j)].measured.name}"
    return f"To train on two, {best} serve best: they are the most distant. {hint}"


def farthest_place(centres: np.ndarray) -> np.ndarray:
    """Return where a new placement would be farthest from those recorded, shape (3,) [m].

    Candidates stand as far from the base axis and as high as those recorded, on all sides of
    the robot but its back.

    Args:
        centres: Of the placements recorded, in the base frame, shape (P, 3) [m].
    """
    radius = float(np.linalg.norm(centres[:, :2], axis=1).mean())
    height = float(centres[:, 2].mean())
    angles = np.deg2rad(np.arange(-90, 91, 15))
    ring = np.stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), height)], axis=1
    )
    gaps = np.linalg.norm(ring[:, None] - centres, axis=2).min(axis=1)
    return ring[int(np.argmax(gaps))]


def _fit(
    robot: Robot,
    parameters: Sequence[Parameter],
    measurements: Sequence[Measurement],
    load: Load | None,
) -> Posterior:
    data = observe(measurements, robot, load=load, tied=False)
    return estimate(extend(robot, parameters), data)


def _floor(alone: Posterior) -> float:
    errors = np.linalg.norm(alone.residuals, axis=1)
    return float(np.average(errors, weights=alone.weights))


def _where(measured: Measurement, socket: int, sample: int) -> str:
    rows = [s for s in measured.placement.samples if s.socket == socket]
    return rows[sample].where or f"{measured.name} socket {socket} sample {sample + 1}"


def _moved(measured: Measurement, changes: Sequence[Change]) -> list[Finding]:
    return [
        Finding(
            "error",
            "moved",
            _where(measured, change.socket, change.sample),
            f"the base moved by {1e3 * change.jump:.1f} mm before sample {change.sample + 1} of "
            f"socket {change.socket}",
            "record it again, or keep both parts by --split-moved",
        )
        for change in changes
    ]


def _bad_floor(measured: Measurement, floor: float, others: Sequence[float]) -> list[Finding]:
    """Return a finding where a placement alone leaves much more than the others do."""
    typical = float(np.median(others)) if len(others) > 1 else np.inf
    if floor <= BAD_FLOOR * typical:
        return []
    return [
        Finding(
            "error",
            "floor",
            str(measured.placement.path or measured.name),
            f"fitted alone it leaves {1e3 * floor:.2f} mm, the others {1e3 * typical:.2f} mm",
            "no model explains it: record it again, or leave it out",
        )
    ]


def _far(measured: Measurement, alone: Posterior, changes: Sequence[Change]) -> list[Finding]:
    """Return samples whose ball is far from their own socket, or close to another one."""
    data = alone.data
    found: list[Finding] = []
    for socket in measured.sockets:
        index = measured.sockets.index(socket)
        if any(change.socket == socket for change in changes):
            continue  # told already
        for sample, row in enumerate(np.flatnonzero(data.sockets == index).tolist()):
            weight = float(alone.weights[row])
            if weight >= FAR:
                continue
            away = np.linalg.norm(alone.points[row] - alone.centres, axis=1)
            nearest = int(np.argmin(away))
            where = _where(measured, socket, sample)
            text = f"{1e3 * away[index]:.1f} mm from socket {socket}, weight {weight:.3f}"
            if nearest != index and away[nearest] < 0.3 * away[index]:
                other = measured.sockets[nearest]
                advice = f"it lies in socket {other}: were the sockets mixed up?"
                found.append(Finding("error", "mislabelled", where, text, advice))
            else:
                advice = "was the ball seated? It hardly counts; delete it if it was not"
                found.append(Finding("warning", "far", where, text, advice))
    return found


def _duplicates(measured: Measurement) -> list[Finding]:
    found: list[Finding] = []
    for socket, rows in zip(measured.sockets, measured.by_socket, strict=True):
        for i, j in combinations(range(len(rows)), 2):
            if np.all(np.abs(rows[i] - rows[j]) < NEAR):
                found.append(
                    Finding(
                        "warning",
                        "duplicate",
                        _where(measured, socket, j),
                        f"nearly the configuration of sample {i + 1} of socket {socket}",
                        "it adds little: guide the arm to other configurations",
                    )
                )
    return found


def _still(measured: Measurement, robot: Robot) -> list[Finding]:
    found: list[Finding] = []
    for k, joint in enumerate(robot.actuated):
        travel = float(np.ptp(measured.positions[:, k]))
        if travel < STILL:
            how = (
                "did not move at all"
                if travel < 1e-9
                else f"moved by {np.rad2deg(travel):.1f} deg only"
            )
            found.append(
                Finding(
                    "warning",
                    "still",
                    str(measured.placement.path or measured.name),
                    f"joint {joint.name!r} {how}",
                    "its parameters stay near nominal: move every joint by 60 deg or more",
                )
            )
    return found

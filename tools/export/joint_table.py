"""Offsets of each joint over its angle, for drivers and controllers that can add them.

A joint that is to stand at q is commanded p = q + offset(q); while its encoder reads p, it stands
at the q that solves the same. A function of a joint's own angle is not the full model: joints give
way by where all others are, too. So the geometry is fitted to the poses of the full model together
with the offsets, and belongs to them.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat
from typing import NamedTuple

import numpy as np

from ...solver.calibration import FullModel, pose_of_numbers
from ...solver.identification.data import Load
from ...solver.identification.model import Deflection
from ...solver.identification.robot import rotation_vectors, workspace
from ...solver.results import CalibratedRobot
from .c_code import literal, name_of_functions
from .request import (
    Exported,
    ExportError,
    Request,
    commented_table,
    cost_at_poses,
    filled,
    plain,
    recorded,
)

OFFSETS = 64
"""Offsets of each joint, unless the user names another number."""
FEWEST, MOST = 2, 360
POSES = 2000
"""Poses within the recorded ranges of the joints, and anywhere, to which offsets are fitted."""
SHARES = 1.0, 1.0, 0.1
"""Weights of the recorded poses, of those within the ranges, and of those anywhere."""
SHORTEST = 1e-3
"""Least range over which a joint has offsets [rad]."""
LEVER = 0.1
"""Length by which a turn of the ball's link counts as a shift of the ball [m]."""
HELD = 1e-9
"""Weight of a change by 1 rad or 1 m, so that what no pose shows stays as the full model has it."""
ROUNDS = 3
"""Times that balls are made linear."""
TURNS = 6
"""Rounds in which a reading becomes a position; each leaves a hundredth of the error."""


@dataclass(frozen=True)
class JointTable:
    """Offsets of m joints at K angles, linear between them, and constant beyond the ends."""

    first: np.ndarray
    """The first angle of each joint, shape (m,) [rad]."""
    step: np.ndarray
    """Spacing of the angles, shape (m,) [rad]."""
    offsets: np.ndarray
    """Shape (m, K) [rad]."""

    @cached_property
    def angles(self) -> np.ndarray:
        """Angles of the offsets, shape (m, K) [rad]."""
        return self.first[:, None] + self.step[:, None] * self._numbers

    @property
    def _numbers(self) -> np.ndarray:
        return np.arange(self.offsets.shape[1], dtype=float)

    def shares(self, q: np.ndarray) -> np.ndarray:
        """Return the share of each offset at positions q, shape (N, m), as (N, m, K)."""
        numbers = self._numbers
        places = np.clip((q - self.first) / self.step, 0, numbers[-1])
        return np.maximum(1 - np.abs(places[:, :, None] - numbers), 0)

    def positions(self, readings: np.ndarray) -> np.ndarray:
        """Return the q that solves q + offset(q) = p for readings p, both of shape (N, m) [rad]."""
        q = readings
        for _ in range(TURNS):
            q = readings - np.einsum("nmk,mk->nm", self.shares(q), self.offsets)
        return q

    def nearest(self, q: np.ndarray, offsets: np.ndarray) -> "JointTable":
        """Return the table of least squares from offsets at positions q, both of shape (N, m)."""
        held = HELD * len(q) * np.eye(self.offsets.shape[1])
        shares = self.shares(q).swapaxes(0, 1)
        rows: list[np.ndarray] = [
            np.linalg.solve(B.T @ B + held, B.T @ offset)
            for B, offset in zip(shares, offsets.T, strict=True)
        ]
        return replace(self, offsets=np.array(rows))


def fit_table(
    arm: FullModel, readings: np.ndarray, count: int
) -> tuple[JointTable, CalibratedRobot]:
    """Return the table of so many offsets a joint, and the rigid robot that it belongs to.

    Args:
        arm: The full model.
        readings: The recorded joint positions, shape (N, m) [rad]; offsets span their ranges.
        count: K, the number of offsets of each joint.
    """
    lower, upper = readings.min(axis=0), readings.max(axis=0)
    span = np.maximum(upper - lower, SHORTEST)
    m = len(span)
    within = lower + span * np.random.default_rng(0).uniform(size=(POSES, m))
    parts = readings, within, workspace(arm.robot, POSES)
    counts = list(map(len, parts))
    p, w = np.concatenate(parts), np.repeat(np.divide(SHARES, counts), counts)
    calibrated = arm.calibrated
    q = calibrated.true_positions(p)
    table = JointTable(lower, span / (count - 1), np.zeros((m, count)))
    table = table.nearest(q, p - q)
    values = calibrated.values
    turned = pose_of_numbers(calibrated.model.origins(values)[-1])[:3, :3]
    balls, links = calibrated.ball(p), arm.flange(p)[:, :3, :3] @ turned
    for _ in range(ROUNDS):
        q = table.positions(p)
        points = calibrated.model.linearise(values, q)
        turns = calibrated.model.rotations(values, q)
        vectors = rotation_vectors(links @ turns.points.swapaxes(1, 2))
        errors = _six_rows(balls - points.points, vectors)
        by_values = _six_rows(points.by_parameters, turns.by_parameters)
        by_q = _six_rows(points.by_joints, turns.by_joints)[:, :, :m, None]
        by_offsets = -by_q * table.shares(q)[:, None]
        J = np.concatenate([by_values, by_offsets.reshape(len(p), 6, -1)], axis=2)
        rows = J.reshape(6 * len(p), -1)
        weighted = (J * w[:, None, None]).reshape(rows.shape)
        H = weighted.T @ rows + HELD * np.eye(rows.shape[1])
        change = np.linalg.solve(H, weighted.T @ errors.ravel())
        values = values + change[: len(values)]
        offsets = table.offsets + change[len(values) :].reshape(m, count)
        table = replace(table, offsets=offsets)
    deflection = Deflection()
    return table, replace(
        calibrated, values=values, deflection=deflection, exported=None
    )


def _six_rows(by_point: np.ndarray, by_turn: np.ndarray) -> np.ndarray:
    """Return derivatives of a ball [m] above those of its link's turn, which a lever makes [m]."""
    return np.concatenate([by_point, LEVER * by_turn], axis=1)


def write(request: Request) -> Exported:
    """Return the table as CSV, YAML and a C header, and the URDF that it belongs to."""
    name = name_of_functions(request)
    count = request.options.get("rows") or OFFSETS
    if not FEWEST <= count <= MOST:
        raise ExportError(f"--rows {count}: {FEWEST} to {MOST} offsets a joint")
    payload = request.options.get("payload")
    arm = request.kinematics
    calibrated = arm.calibrated
    if not calibrated.deflection.extensions:
        raise ExportError(
            "--to joint-table: the calibration corrects no joint; calibrated.urdf holds all of it"
        )
    readings = recorded(request)
    table, rigid = fit_table(arm, readings, count)
    loss = cost_at_poses(
        request,
        "the part of the corrections that a joint's own angle does not tell",
        lambda p: rigid.ball(table.positions(p)),
        calibrated.ball,
    )
    urdf = cost_at_poses(request, "", calibrated.geometric_ball, calibrated.ball)
    mass = calibrated.load.payload if payload is None else payload[0]
    about = [
        *request.identity.lines(),
        f"{name}.urdf says where the arm is when its joints stand at some angles. To bring a joint",
        "to an angle, command the angle and its offset. Radians; metres for a prismatic joint.",
        "gravity is the part of an offset that weight makes on average, with "
        f"{mass:g} kg beyond the URDF's.",
        f"Left to the full model, at the ball: {1e3 * loss.mean:.3f} mm over the recorded poses, "
        f"{1e3 * loss.anywhere:.3f} mm all over the workspace, on average.",
    ]
    # Where joints stand at readings, and the offsets that weight alone makes there.
    weightless = replace(calibrated, load=Load((0.0, 0.0, 0.0), 0.0))
    q = calibrated.true_positions(readings)
    gravity = table.nearest(q, weightless.true_positions(readings) - q).offsets
    names = calibrated.robot.joint_names
    rows = list(map(_Row, names, table.angles, table.offsets, gravity))
    words: dict[str, object] = {"about": list(map(plain, about)), "rows": rows}
    words |= {"identity": request.identity.in_yaml, "payload": mass, "count": count}
    words |= {"arm": name, "turns": TURNS}
    files = {
        request.file.name: _as_csv(about, rows),
        f"{name}.yaml": filled("joint_table.yaml.j2", **words),
        f"{name}.h": filled("joint_table.h.j2", **words),
        f"{name}.urdf": rigid.urdf(request.file.parent),
    }
    lines = (
        f"calibrated.urdf alone leaves {1e3 * urdf.mean:.3f} mm over the recorded poses.",
        f"Load {name}.urdf, not calibrated.urdf: it belongs to the offsets. {name}.csv, .yaml and "
        ".h hold the same table.",
    )
    return Exported(files, (loss,), lines)


class _Row(NamedTuple):
    """The offsets of one joint as the files have them."""

    joint: str
    angles: np.ndarray
    offsets: np.ndarray
    gravity: np.ndarray

    @property
    def in_c(self) -> str:
        """The joint's name as a string of C."""
        return literal(self.joint)

    @property
    def in_yaml(self) -> str:
        """The joint's name as a string of YAML."""
        return json.dumps(self.joint)

    @property
    def step(self) -> str:
        """Spacing of the angles [rad]."""
        return f"{self.angles[1] - self.angles[0]:.15f}"

    @staticmethod
    def listed(numbers: Iterable[float]) -> str:
        """Return numbers that every reader takes for such: 1e-05 is text to some of YAML's."""
        return ", ".join(f"{number:.12f}" for number in numbers)


def _as_csv(about: Iterable[str], rows: Iterable[_Row]) -> bytes:
    """Return a line for each offset."""
    lines: list[tuple[str, ...]] = [("joint", "angle", "offset", "gravity")]
    for row in rows:
        columns = (row.listed(column).split(", ") for column in row[1:])
        lines += zip(repeat(row.joint), *columns, strict=False)
    return commented_table(about, lines)

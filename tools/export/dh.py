"""Denavit-Hartenberg tables, standard and modified (Craig's), and what remains: docs/use.md.

A step between axes is Rz(theta) Tz(d) Tx(a) Rx(alpha), or Hayati's with Ry(beta) after it, d = 0.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import reduce
from typing import NamedTuple

import numpy as np

from ...errors import fixed
from ...solver.calibration import pose_of_numbers
from ...solver.identification.robot import Joint, turn
from .request import Exported, Request, commented_table, exported

NEARLY_PARALLEL = math.radians(5.0)
"""Lines with a smaller angle between them get Hayati's form."""


class Row(NamedTuple):
    """The numbers of one joint, or of a step between two axes."""

    joint: str = ""
    type: str = ""
    """``revolute`` (continuous too) or ``prismatic``."""
    form: str = ""
    """``dh``, ``mdh`` in a modified table, or ``hayati``: the row's alpha is of such a step."""
    theta: float = 0.0
    """[rad], added to q of a revolute joint."""
    d: float = 0.0
    """[m], added to q of a prismatic joint."""
    a: float = 0.0
    alpha: float = 0.0
    beta: float = 0.0
    """[rad], Hayati's parameter; zero in every row of another form."""

    @property
    def matrix(self) -> np.ndarray:
        """The step's transform, shape (4, 4)."""
        along = (0, 0, self.d, 0, 0, self.theta)
        across = (self.a, 0, 0, self.alpha, 0, 0)
        hayati = (0, 0, 0, 0, self.beta, 0)
        return reduce(np.matmul, pose_of_numbers([along, across, hayati]))


def dh_table(
    joints: tuple[Joint, ...], origins: np.ndarray, standard: bool
) -> tuple[list[Row], dict[str, np.ndarray]]:
    """Return the rows of a chain, by its origins, shape (joints, 6) [m, rad], and what is left.

    That is, each of shape (4, 4): from the robot's base to the first line's frame (``base``), and
    from the last line's frame to the link that carries the ball (``flange``), and to it (``tool``).
    """
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    steps: list[Row] = []
    # From the frame on the present line to the URDF's frame of that joint: a turn about the line
    # and a shift along it, so that it may stand on either side of the joint's motion.
    offset = np.eye(4)
    base = np.eye(4)
    begin = 0
    poses = pose_of_numbers(origins)
    for i in moving:
        upright = _to_axis(joints[i].axis)
        to_line = reduce(np.matmul, poses[begin : i + 1], offset) @ upright
        if begin == 0:
            base = to_line
            offset = np.eye(4)
        else:
            steps.append(_step(to_line))
            offset = np.linalg.inv(steps[-1].matrix) @ to_line
        offset = offset @ upright.T
        begin = i + 1
    flange = reduce(np.matmul, poses[begin:-1], offset)
    rows: list[Row] = []
    form = "dh" if standard else "mdh"
    alongs = [*steps, Row()]
    overs = alongs if standard else [Row(), *steps]
    for i, along, over in zip(moving, alongs, overs, strict=True):
        kind = "prismatic" if joints[i].type == "prismatic" else "revolute"
        row = over._replace(joint=joints[i].name, type=kind, form=over.form or form)
        rows.append(row._replace(theta=along.theta, d=along.d))
    return rows, {"base": base, "flange": flange, "tool": flange @ poses[-1]}


def _to_axis(axis: Sequence[float]) -> np.ndarray:
    """Return the smallest turn that carries the z axis to another axis, shape (4, 4)."""
    x, y, z = axis
    sine = math.hypot(x, y)
    if sine < 1e-12:
        side = math.copysign(1, z)
        return np.diag([1.0, side, side, 1.0])
    angle = math.atan2(sine, z)
    T = np.eye(4)
    T[:3, :3] = turn(np.array([-y, x, 0.0]) * (angle / sine))
    return T


def _step(to_line: np.ndarray) -> Row:
    """Return the step from a frame to another line, which is the z axis of ``to_line``."""
    point = to_line[:3, 3]
    line = to_line[:3, 2]
    x, y, z = line.tolist()
    sine = math.hypot(x, y)
    if sine < math.sin(NEARLY_PARALLEL):
        return _hayati(point, line)
    normal = np.array([-y, x, 0.0]) / sine
    if normal[0] < -1e-9 or (abs(normal[0]) <= 1e-9 and normal[1] < 0):
        normal = -normal  # so that theta stays within a quarter turn of zero
    upright = np.array([0.0, 0.0, 1.0])
    directions = np.stack([upright, normal, -line], axis=1)
    d, a, _ = np.linalg.solve(directions, point).tolist()
    alpha = math.atan2(float(np.cross(upright, line) @ normal), z)
    theta = math.atan2(normal[1], normal[0])
    return Row(theta=theta, d=d, a=a, alpha=alpha)


def _hayati(point: np.ndarray, line: np.ndarray) -> Row:
    # The line pierces the plane z = 0 here.
    x, y, _ = point - point[2] / line[2] * line
    sign = -1.0 if x < 0 else 1.0
    a = sign * math.hypot(x, y)
    theta = math.atan2(sign * y, sign * x)
    u, v, w = pose_of_numbers((0, 0, 0, 0, 0, -theta))[:3, :3] @ line
    beta = math.atan2(u, math.hypot(v, w))
    alpha = math.atan2(-v, w)
    return Row(
        form="hayati",
        theta=theta,
        a=a,
        alpha=alpha,
        beta=beta,
    )


def write(request: Request) -> Exported:
    """Return the table as JSON or CSV, as the file's ending says, and as lines to print."""
    is_standard = request.format == "dh"
    convention = "standard" if is_standard else "modified"
    robot = request.robot
    rows, frames = dh_table(robot.joints, request.origins, is_standard)
    along = "J(q) Rz(theta) Tz(d)"
    across = "Tx(a) Rx(alpha) Ry(beta)"
    row = f"{along} {across}" if is_standard else f"{across} {along}"
    explained = (
        f"{convention.title()}: T = base * product of [{row}] * tool",
        "J(q) = Rz(q) for a revolute joint, Tz(q) for a prismatic one; metres and radians.",
        "beta is Hayati's parameter, of rows of the form `hayati`: two axes are nearly parallel.",
    )
    if request.file.suffix == ".json":
        document = {
            "convention": convention,
            "units": {"lengths": "m", "angles": "rad"},
            **asdict(request.identity),
            "base_link": robot.base,
            "flange_link": robot.ball_joint.parent,
            "tip_link": robot.tip,
            "joints": [row._asdict() for row in rows],
            **{name: T.tolist() for name, T in frames.items()},
        }
        text = f"{json.dumps(document, indent=1)}\n".encode()
    else:
        about = [*request.identity.lines(), *explained]
        for name, T in frames.items():
            numbers = " ".join(map(repr, T[:3].ravel().tolist()))
            about.append(f"{name} {numbers}")
        text = commented_table(about, [Row._fields, *rows])
    return exported(request, text, (*explained, *_printed(rows, frames)))


def _printed(rows: list[Row], frames: dict[str, np.ndarray]) -> list[str]:
    """Return the table in millimetres and degrees."""
    width = max(len(row.joint) for row in rows)
    head = ("theta deg", "d mm", "a mm", "alpha deg", "beta deg")
    lines = [f"{'joint':<{width}}  form  " + "".join(f"{word:>13}" for word in head)]
    for row in rows:
        theta, alpha, beta = map(math.degrees, (row.theta, row.alpha, row.beta))
        numbers = (theta, 1e3 * row.d, 1e3 * row.a, alpha, beta)
        columns = "".join(f"{fixed(n, 5):>13}" for n in numbers)
        lines.append(f"{row.joint:<{width}}  {row.form:<6}{columns}")
    for name in ("base", "tool"):
        xyz = " ".join(fixed(1e3 * value, 5) for value in frames[name][:3, 3])
        lines.append(f"{name}: {xyz} mm, and a turn that is in the file")
    return lines

"""Arms of Universal Robots as their own controllers compute them, by the factory's calibration.

A controller's ``calibration.conf`` has what the factory found each number of the Denavit-Hartenberg
table to be off (``delta_theta``, ``delta_d``, ``delta_a``, ``delta_alpha``), and its kinematics are

    T = A_1(q_1) ... A_6(q_6)      A(q) = Rz(q + delta_theta) Tz(d) Tx(a) Rx(alpha)
"""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ....errors import LARGEST_DOCUMENT, read_bytes, reason_of
from .chain import Joint
from .segments import link_poses
from .urdf import Robot
from .urdf_text import ModelError, Origin

TABLES: dict[str, list[float]] = json.loads(
    (Path(__file__).parent / "shipped" / "ur_tables.json").read_text("utf-8")
)
"""d1, a2, a3, d4, d5, d6 of each type, by the maker's page on Denavit-Hartenberg parameters [m]."""
ALPHA = np.pi / 2 * np.array([1, 0, 0, 1, -1, 0])
SAME = 1e-4
"""Largest difference of a URDF from its type's table [m, rad]."""
OF_FACTORY = 0.02
"""No factory's calibration moves the flange that far [m]."""
POSTURES = 20
"""Postures in which two models are compared."""
_ROW = r"^\s*delta_{}\s*=\s*\[([^\]]*)\]"


def ur_controller(robot: Robot, file: str | Path) -> Robot:
    """Return an arm as its controller computes it, in the controller's own base frame.

    The file is the controller's ``calibration.conf``.

    Raises:
        ModelError: The file cannot be read, a row is missing, or the robot is of no type known.
    """
    deltas = _deltas(file)
    moving = robot.actuated
    first = robot.joints.index(moving[0])
    last = robot.joints.index(moving[-1])
    beyond = robot.joints[last + 1 :]
    sizes = _sizes_of(robot.joints[first : last + 1])
    if sizes is None:
        raise ModelError(f"{robot.name}: {file} is for one of {', '.join(TABLES)}")
    joints = (*_chain(moving, sizes, deltas), *beyond)
    return replace(robot, base="base", joints=joints)


def _deltas(file: str | Path) -> np.ndarray:
    """Return what a ``calibration.conf`` adds to theta, d, a and alpha, shape (4, 6)."""
    try:
        text = read_bytes(file, LARGEST_DOCUMENT).decode()
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"{file}: cannot be read: {reason_of(error)}") from None
    deltas: list[np.ndarray] = []
    for name in ("theta", "d", "a", "alpha"):
        row = re.search(_ROW.format(name), text, re.M)
        words = row[1].split(",") if row else []
        try:
            numbers = np.array([float(word) for word in words])
        except ValueError:
            numbers = np.zeros(0)
        if numbers.shape != (6,) or not np.isfinite(numbers).all():
            raise ModelError(
                f"{file}: give the controller's calibration.conf: six numbers delta_{name} lack"
            )
        deltas.append(numbers)
    return np.array(deltas)


def _sizes_of(joints: Sequence[Joint]) -> list[float] | None:
    """Return the table of the type that has such joints, from the first that moves to the last."""
    moving = [joint for joint in joints if joint.actuated]
    if len(moving) != 6:
        return None
    q = np.random.default_rng(0).uniform(-2, 2, (4, 6))
    flange = link_poses(joints, q)[:, -1]
    for sizes in TABLES.values():
        chain = _chain(moving, sizes, np.zeros((4, 6)))
        of_table = link_poses(chain, q)[:, -1]
        if np.abs(of_table - flange).max() < SAME:
            return sizes
    return None


def _chain(
    moving: Sequence[Joint],
    sizes: Sequence[float],
    deltas: np.ndarray,
) -> tuple[Joint, ...]:
    """Return a table's joints, each with the step A of the one before; the last one is fixed."""
    d1, a2, a3, d4, d5, d6 = sizes
    table = [np.zeros(6), [d1, 0, 0, d4, d5, d6], [0, a2, a3, 0, 0, 0], ALPHA]
    theta, d, a, alpha = np.array(table) + deltas
    x = a * np.cos(theta)
    y = a * np.sin(theta)
    steps = np.column_stack([x, y, d, alpha, 0 * d, theta])
    *origins, last = Origin(), *map(Origin.of, steps)
    about_z = [
        replace(joint, axis=(0.0, 0.0, 1.0), tilt_axes=None, origin=origin)
        for joint, origin in zip(moving, origins, strict=True)
    ]
    end = replace(moving[-1], name="flange_of_table", type="fixed", origin=last)
    return (*about_z, end)


def check_controller(
    robot: Robot,
    controller: Robot,
    file: str | Path | None,
) -> None:
    """Refuse a controller's model, or one by its factory's file, that is another arm's.

    A factory's calibration moves the flange by millimetres. The flanges' places in some postures
    are compared after the base frames are laid over each other: bases of one name, and that of a
    controller's file, stand at one place and may be turned; others may stand elsewhere, too.

    Raises:
        ModelError: The joints are not as many, or the flange is 20 mm off or more.
    """
    what = str(file or controller.source)
    m = len(robot.actuated)
    if len(controller.actuated) != m:
        raise ModelError(
            f"controller {what}: {len(controller.actuated)} joints, but {robot.name} has {m}"
        )
    postures = np.random.default_rng(0).uniform(-2, 2, (POSTURES, m))
    nominal = _flanges(robot, postures)
    believed = _flanges(controller, postures)
    if file is None and controller.base != robot.base:
        nominal = nominal - nominal.mean(axis=0)
        believed = believed - believed.mean(axis=0)
    U, _, Vt = np.linalg.svd(nominal.T @ believed)
    handedness = np.linalg.det(U @ Vt)
    R = U @ np.diag([1.0, 1.0, handedness]) @ Vt
    gaps = np.linalg.norm(nominal - believed @ R.T, axis=1)
    gap = float(gaps.max())
    if gap >= OF_FACTORY:
        raise ModelError(
            f"controller {what}: its flange stands up to {1e3 * gap:.0f} mm from that of "
            f"{robot.name} in the same posture. A factory's calibration moves it by "
            "millimetres: give that of this arm, not another arm's"
        )


def _flanges(arm: Robot, postures: np.ndarray) -> np.ndarray:
    """Return the flange's places in postures, shape (N, m), as (N, 3) [m]."""
    poses = link_poses(arm.joints[:-1], postures)
    return poses[:, -1, :, 3]

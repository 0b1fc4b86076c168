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

from ...errors import LARGEST_DOCUMENT, read_bytes, reason_of
from .chain import Joint
from .kinematics import link_poses
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
    moving = robot.actuated
    first, last = map(robot.joints.index, (moving[0], moving[-1]))
    q = np.random.default_rng(0).uniform(-2, 2, (4, len(moving)))
    flange = link_poses(robot.joints[first : last + 1], q)[:, -1]
    for sizes in TABLES.values() if len(moving) == 6 else ():
        of_table = link_poses(_chain(moving, sizes, np.zeros((4, 6))), q)[:, -1]
        if np.abs(of_table - flange).max() < SAME:
            joints = (
                *_chain(moving, sizes, np.array(deltas)),
                *robot.joints[last + 1 :],
            )
            return replace(robot, base="base", joints=joints)
    raise ModelError(f"{robot.name}: {file} is for one of {', '.join(TABLES)}")


def _chain(
    moving: Sequence[Joint], sizes: Sequence[float], deltas: np.ndarray
) -> tuple[Joint, ...]:
    """Return a table's joints, each with the step A of the one before; the last one is fixed."""
    d1, a2, a3, d4, d5, d6 = sizes
    table = [np.zeros(6), [d1, 0, 0, d4, d5, d6], [0, a2, a3, 0, 0, 0], ALPHA]
    theta, d, a, alpha = np.array(table) + deltas
    steps = np.column_stack(
        [a * np.cos(theta), a * np.sin(theta), d, alpha, 0 * d, theta]
    )
    origin, *origins = Origin(), *map(Origin.of, steps)
    about_z: list[Joint] = []
    for joint, following in zip(moving, origins, strict=True):
        about_z.append(
            replace(joint, axis=(0.0, 0.0, 1.0), tilt_axes=None, origin=origin)
        )
        origin = following
    end = replace(moving[-1], name="flange_of_table", type="fixed", origin=origin)
    return (*about_z, end)


def check_controller(
    robot: Robot, controller: Robot, file: str | Path | None = None
) -> None:
    """Refuse a controller's model, or one by its factory's file, that is another arm's.

    A factory's calibration moves the flange by millimetres. The flanges' places in some postures
    are compared after the base frames are laid over each other: bases of one name, and that of a
    controller's file, stand at one place and may be turned; others may stand elsewhere, too.

    Raises:
        ModelError: The joints are not as many, or the flange is 20 mm off or more.
    """
    what = str(file or controller.source)
    if len(controller.actuated) != len(robot.actuated):
        raise ModelError(
            f"controller {what}: {len(controller.actuated)} joints, but {robot.name} has "
            f"{len(robot.actuated)}"
        )
    postures = np.random.default_rng(0).uniform(-2, 2, (POSTURES, len(robot.actuated)))
    arms = robot, controller
    flanges = np.array(
        [link_poses(arm.joints[:-1], postures)[:, -1, :, 3] for arm in arms]
    )
    if file is None and controller.base != robot.base:
        flanges -= flanges.mean(axis=1, keepdims=True)
    nominal, believed = flanges
    U, _, Vt = np.linalg.svd(nominal.T @ believed)
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    gap = float(np.linalg.norm(nominal - believed @ R.T, axis=1).max())
    if gap >= OF_FACTORY:
        raise ModelError(
            f"controller {what}: its flange stands up to {1e3 * gap:.0f} mm from that of "
            f"{robot.name} in the same posture. A factory's calibration moves it by "
            "millimetres: give that of this arm, not another arm's"
        )

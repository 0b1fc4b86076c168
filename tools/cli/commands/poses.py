"""``mukca poses``: where the true tool stands at joint positions."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import Terminal, argument, one_arm
from .command import PathOptions, located, read_rows, write_rows


@dataclass(frozen=True, kw_only=True)
class Options(PathOptions):
    """Options of ``mukca poses``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    joints: Path = argument("joint positions, one configuration a line", "JOINTS.csv")


def run(options: Options, terminal: Terminal) -> int:
    """Write the pose of the tool for each row, as place and quaternion."""
    from ....solver.calibration import load_calibration, quaternion_of

    calibration, setup = load_calibration(one_arm(options.calibration)), options.setup()
    q, wheres = read_rows(options.joints, [calibration.robot.joint_names])
    with located(wheres, terminal):
        T = calibration.flange(q, **setup)
    rows = np.hstack([T[:, :3, 3], quaternion_of(T[:, :3, :3])])
    write_rows(options, terminal, ("x", "y", "z", "qx", "qy", "qz", "qw"), rows)
    return 0

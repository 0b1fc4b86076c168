"""``mukca poses``: where the true tool stands at joint positions."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....solver import calibration
from .. import Terminal, argument, one_arm
from .command import PathOptions, located, streamed, written


@dataclass(frozen=True, kw_only=True)
class Options(PathOptions):
    """Options of ``mukca poses``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    joints: Path = argument(
        "joint positions, one configuration a line; - for standard input", "JOINTS.csv"
    )


def run(options: Options, terminal: Terminal) -> int:
    """Write the pose of the tool for each row, as place and quaternion."""
    held, setup = calibration.load_calibration(one_arm(options.calibration)), options.setup()
    header = ("x", "y", "z", "qx", "qy", "qz", "qw")
    with written(options, terminal, header, options.joints) as write:
        for q, wheres in streamed(options.joints, [held.robot.joint_names]):
            with located(wheres, terminal):
                T = held.flange(q, **setup)
            write(*np.hstack([T[:, :3, 3], calibration.quaternion_of(T[:, :3, :3])]))
    return 0

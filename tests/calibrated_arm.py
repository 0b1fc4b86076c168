"""A simulated arm, its calibration, and what it would record since."""

from dataclasses import dataclass

import numpy as np

import mukca
from mukca.recorder import Placement
from mukca.solver.results import CalibratedRobot


@dataclass(frozen=True)
class Simulated:
    """An arm whose truth is known, calibrated at two bases, and recorded at a third."""

    truth: CalibratedRobot
    """Predicts where the ball truly is."""
    calibration: mukca.Calibration
    later: Placement
    """Recorded since, joints in order, 8 samples in each socket."""

    def read(self, offsets: dict[int, float]) -> Placement:
        """Return the later placement, read by joints whose zeros are off [rad]."""
        q = self.later.positions.copy()
        for joint, offset in offsets.items():
            q[:, joint] -= offset
        return Placement.of_arrays(
            "since", q, self.later.sockets, self.later.joint_names, distance=0.05
        )


def simulate() -> Simulated:
    """Return the arm; the same each time."""
    robot = mukca.load_robot("panda")
    flaws = {"compliance": 4e-5, "tilt": 2e-5}
    truth, (*train, later) = mukca.simulate_recordings(robot, 3, seed=3, samples=16, **flaws)
    calibration = mukca.calibrate(robot, train)
    own = np.r_[0:8, 16:24]
    few = Placement.of_arrays(
        "later", later.positions[own], later.sockets[own], later.joint_names, distance=0.05
    )
    return Simulated(truth, calibration, few)

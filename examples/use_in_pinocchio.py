"""Use a calibrated robot in Pinocchio: its URDF is a URDF like any other.

Needs Pinocchio (pip install pin). Give a folder that `mukca solve --out` or `save` wrote:

    python use_in_pinocchio.py calibrated
"""

import sys
from pathlib import Path

import numpy as np
import pinocchio

import mukca

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "calibrated")

if not folder.exists():  # calibrate from recordings of a simulated arm
    panda = mukca.load_robot("panda")
    _, (train, test) = mukca.simulate_recordings(panda, 2, samples=12)
    mukca.calibrate(panda, train, test=test, method="paper").save(folder)

calibration = mukca.load_calibration(folder / "calibration.json")
robot = calibration.robot
model = pinocchio.buildModelFromUrdf(str(folder / "calibrated.urdf"))
data = model.createData()

angles = np.linspace(-0.6, 0.6, len(robot.joint_names))  # [rad], in chain order
q = np.zeros(model.nq)  # Pinocchio has an order of its own, and all joints of the URDF
q[[model.joints[model.getJointId(name)].idx_q for name in robot.joint_names]] = angles

pinocchio.framesForwardKinematics(model, data, q)
by_pinocchio = data.oMf[model.getFrameId(robot.tip)].translation
by_mukca = calibration.calibrated.geometric_ball(angles)  # what the exported URDF says
nominal = calibration.calibrated.nominal_ball(angles)

print("ball, by Pinocchio [m]:", by_pinocchio)
print("ball, by mukca [m]:    ", by_mukca)
print(f"they differ by {np.linalg.norm(by_pinocchio - by_mukca):.1e} m; ", end="")
print(f"the nominal URDF is off by {1e3 * np.linalg.norm(by_mukca - nominal):.1f} mm")

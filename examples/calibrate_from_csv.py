"""Calibrate a Franka Panda from CSV files of joint angles.

A placement is a folder with hole_0.csv and hole_1.csv, one file for each socket: one configuration
a line, joint angles in radians in chain order. Give a folder of placements:

    python calibrate_from_csv.py recordings
"""

import sys
from pathlib import Path

import numpy as np

import mukca

robot = mukca.load_robot("panda")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else "recordings")

# Nothing was recorded yet: a simulated arm shows what the files look like.
if not folder.exists():
    _, placements = mukca.simulate_recordings(robot, 3, samples=12)
    for placement in placements:
        (folder / placement.name).mkdir(parents=True)
        for socket in (0, 1):
            # Shape (samples, joints) [rad].
            q = placement.positions[placement.sockets == socket]
            np.savetxt(folder / placement.name / f"hole_{socket}.csv", q, delimiter=",")

# Fit to all placements; fits that each leave one out say whether it worked.
placements = mukca.read_placements(folder)
calibration = mukca.calibrate(robot, placements, distance=0.05)

print(calibration)
outputs = calibration.save("calibrated", force=True)  # over what an earlier run wrote
page = mukca.write_report(calibration, "calibrated", force=True)["report"]
print("Use", outputs["urdf"], "in place of the nominal URDF; read", page, "first.")

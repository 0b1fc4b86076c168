"""Calibrate an arm of one's own, by a URDF that knows nothing of a ball.

Give the URDF and a folder of placements, and say below where the ball is:

    python own_urdf.py my_arm.urdf recordings
"""

import sys
from pathlib import Path

import mukca

urdf = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("my_arm.urdf")

# The ball is screwed to the link tool0, its centre 60 mm along that link's z axis. This need not
# be exact: the calibration finds the place of the ball, too.
robot = mukca.load_robot(urdf, base="base_link", flange="tool0", ball=(0, 0, 0.06))
print(robot)

if len(sys.argv) > 2:
    placements = mukca.read_placements(sys.argv[2])
else:  # nothing was recorded yet: a simulated arm that differs from its URDF
    _, placements = mukca.simulate_recordings(robot, 3, samples=12)

# Whatever is known for sure can be kept as it is, here the place of the first joint.
calibration = mukca.calibrate(
    robot, placements[0], test=placements[1:], fix=["waist.xyz"]
)
print(calibration)

changed = [p for p in calibration.document.parameters if p.unit == "m"]
largest = max(changed, key=lambda p: abs(p.calibrated - p.nominal))
print(
    f"{largest.name} changed most: by {1e3 * (largest.calibrated - largest.nominal):+.2f} mm"
)
calibration.save("my_arm_calibrated", force=True)  # over what an earlier run wrote

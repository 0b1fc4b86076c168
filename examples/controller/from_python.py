"""Call the C model of an arm from Python, by ctypes.

mukca export calibrated/calibration.json --to c --out arm.c
cc -std=c99 -O2 -shared -fPIC arm.c -o arm.so -lm
python from_python.py arm.so 7
"""

import ctypes
import sys
from pathlib import Path

library = ctypes.CDLL(str(Path(sys.argv[1]).resolve()))
joints = int(sys.argv[2])
Joints, Point = ctypes.c_double * joints, ctypes.c_double * 3

q, command, ball = Joints(*[0.3] * joints), Joints(), Point()
library.arm_ball(q, ball)
print("the ball, while the robot reports 0.3 rad everywhere [m]:", *ball)
if library.arm_command(q, command) != 0:
    sys.exit("not a configuration")
print("command this for joints that truly stand at 0.3 rad:", *command)

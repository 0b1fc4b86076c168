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

lower, upper = (Joints.in_dll(library, f"arm_{end}") for end in ("lower", "upper"))
middle = [(max(a, -3.0) + min(b, 3.0)) / 2 for a, b in zip(lower, upper, strict=True)]
q, command, ball = Joints(*(x + 0.3 for x in middle)), Joints(), Point()
library.arm_ball(q, ball)
print("the ball, while the robot is 0.3 rad off the middle of its ranges [m]:", *ball)
if library.arm_command(q, command) != 0:
    sys.exit("no such configuration within the limits")
print("command this for the flange that calibrated.urdf has there:", *command)

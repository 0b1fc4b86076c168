"""Stream and print the joint states of a live arm. It is only read, never moved.

Give the address of an arm, as after `mukca stream --driver`:

    python stream_arm.py franka:172.16.0.2
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import mukca


def simulated_arm() -> str:
    """Return the address of a simulated arm that is led through three configurations."""
    file = Path(tempfile.mkdtemp()) / "configurations.csv"
    configurations = np.random.default_rng(0).uniform(-1, 1, (3, 7))
    np.savetxt(file, configurations, delimiter=",")
    return f"mock:{file}?rate=50&hold=0.1&move=0.5"


address = sys.argv[1] if len(sys.argv) > 1 else simulated_arm()
count = int(sys.argv[2]) if len(sys.argv) > 2 else 20

with mukca.open_driver(address) as driver:
    print(*driver.joint_names)
    for number, state in enumerate(driver, start=1):
        angles = " ".join(f"{np.rad2deg(q):8.2f}" for q in state.position)
        print(f"{state.stamp:10.3f} s  {angles} deg", flush=True)
        if number == count:
            break

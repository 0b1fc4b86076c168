"""RobotState as libfranka's own header lays it out, compiled, and read bit for bit.

::

    git clone https://github.com/frankarobotics/libfranka-common    (a version of FCI each)
    MUKCA_LIBFRANKA_COMMON=libfranka-common/include pytest tests/foreign

Several folders are separated by colons. Without them, or without g++, the test is skipped.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from mukca.drivers.arms.franka import decode_state

INCLUDES = [path for path in os.environ.get("MUKCA_LIBFRANKA_COMMON", "").split(":") if path]
PROGRAM = Path(__file__).with_name("states.cpp")


@pytest.mark.skipif(not INCLUDES or not shutil.which("g++"), reason="no MUKCA_LIBFRANKA_COMMON")
@pytest.mark.parametrize("include", INCLUDES or [""])
def test_states_that_libfranka_s_structs_hold_are_read_bit_for_bit(include, tmp_path):
    program = tmp_path / "states"
    subprocess.run(["g++", "-std=c++17", f"-I{Path(include)}", PROGRAM, "-o", program], check=True)
    data = subprocess.run([program], check=True, capture_output=True).stdout
    size = len(data) // 10_000
    for number in range(1, 10_001):
        state, status = decode_state(data[(number - 1) * size : number * size])
        angles = [(number % 613 - 306) / 64 / (joint + 1) for joint in range(7)]
        assert state.stamp == number * 1e-3 and status.count("; ") == 1
        assert state.position == pytest.approx(angles, rel=1e-7)  # float32 from FCI 10 on
        assert state.effort == tuple(number % 997 / 16 - joint for joint in range(7))

"""A robot's side of FCI 10 that others wrote: the package franka-sim, compared bit for bit.

::

    pip install franka-sim==1.1.7
    pytest tests/foreign

Its server packs each state field by field as libfranka's header lists them, from a description of
its own. Without the package the test is skipped. The other clients and servers of others that can
be installed are in ``tests/drivers/test_real_clients.py``, which run wherever they are installed:
libfranka (panda-python, pylibfranka), ur-rtde, piper_sdk, and the makers' packages for Feetech,
Dynamixel and xArm.
"""

import random
import struct

import pytest

from mukca import JointState
from mukca.drivers.arms.franka import decode_state
from mukca.tools.emulators.udp_arms import encode_state

robot_state = pytest.importorskip("franka_sim.robot_state", reason="franka-sim is not installed")

STATES = 10_000


def test_states_of_another_s_fci_server_are_read_bit_for_bit():
    """All values that are read, at random, and errors among the flags; ours are as long."""
    source = random.Random(5)
    theirs = robot_state.RobotState()
    for number in range(1, STATES + 1):
        q, tau = ([_float32(source.uniform(-limit, limit)) for _ in range(7)] for limit in (6, 87))
        errors = [source.random() < 0.02 for _ in range(41)]
        theirs.state |= {"message_id": number, "q": q, "tau_J": tau, "errors": errors}
        theirs.state |= {"robot_mode": source.randrange(7), "dq": [9.0] * 7, "q_d": [8.0] * 7}
        datagram = theirs.pack_state()
        read, status = decode_state(datagram)
        assert read == JointState(number * 1e-3, tuple(q), tuple(tau))
        assert status.count("; ") == sum(errors)
        assert len(datagram) == len(encode_state(10, number, JointState(0.0, tuple(q), tuple(tau))))


def _float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]

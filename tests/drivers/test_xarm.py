"""UFACTORY's reports: byte layouts, the maker's own structures, and what must not pass."""

import importlib.util
import math
import struct

import pytest
from emulation import emulated
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.drivers import DriverError, JointState, Reason
from mukca.drivers.arms.xarm import FAST, PORTS, REAL, RICH, XArm, decode_report, take_report
from mukca.tools.emulators.xarm import XArmEmulator

Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6)
STATE = JointState(0.0, Q, (1.0, -2.0, 3.0, -4.0, 5.0, -6.0))
LAYOUTS = {30000: FAST, 30002: RICH, 30003: REAL}


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """What the emulator sends, by port."""
    with emulated("xarm", tmp_path_factory.mktemp("xarm")) as emulation:
        emulator: XArmEmulator = emulation.running.emulator
        fast, rich = emulator._fast(3, STATE), emulator._rich(STATE)
        return {30000: fast, 30002: rich, 30003: emulator._real(STATE)}


def test_the_first_bytes(reports):
    """Size 87, mode 2 and state 2, no commands waiting, 0.1 and -0.2 rad."""
    assert reports[30003][:15] == bytes.fromhex("00000057 22 0000 cdcccc3d cdcc4cbe")
    assert len(reports[30003]) == 87


@pytest.mark.parametrize("port", LAYOUTS)
def test_a_report(port, reports):
    report = decode_report(reports[port], LAYOUTS[port])
    assert report.angles == pytest.approx((*Q, 0.0))
    assert report.status == "joint teaching, ready"
    assert report.joints == (6 if port == 30002 else None)
    assert report.time == (pytest.approx(5.012) if port == 30000 else None)


@pytest.mark.parametrize("port", LAYOUTS)
def test_the_makers_structures_read_what_the_emulator_sends(port, reports):
    if importlib.util.find_spec("xarm") is None:
        pytest.skip("xarm-python-sdk is not installed")
    from xarm.x3.report import ReportDataStructure

    theirs = ReportDataStructure.create(port)
    theirs.update(reports[port])
    assert theirs.data_size == len(reports[port])
    assert theirs.actual_joint_angle == pytest.approx([*Q, 0.0])
    assert theirs.estimated_joint_torque == pytest.approx([*(STATE.effort or ()), 0.0])
    assert (theirs.mode, theirs.state) == (2, 2)
    if port == 30000:
        assert theirs.timestamp == 5_012_000
    if port == 30002:
        assert theirs.robot_axis == 6


@pytest.mark.parametrize("port", LAYOUTS)
def test_what_is_no_report(port, reports):
    good, layout = reports[port], LAYOUTS[port]
    for wrong in (math.nan, math.inf, 100.0):
        bad = bytearray(good)
        struct.pack_into("<f", bad, layout.angles + 8, wrong)
        with pytest.raises(ValueError, match="impossible joint angles"):
            decode_report(bytes(bad), layout)
    for message in (b"", good[:-1], good + b"\0", good[:60]):
        with pytest.raises(ValueError, match="bytes"):
            decode_report(message, layout)


@pytest.mark.slow
@settings(max_examples=200)
@given(st.binary(max_size=200))
def test_a_stream_is_cut_by_its_sizes(noise):
    stream = bytearray(noise)
    try:
        while (report := take_report(stream)) is not None:
            assert int.from_bytes(report[:4], "big") == len(report)
            decode_report(report, REAL)
    except ValueError:
        return
    assert len(stream) < 4 or 87 <= int.from_bytes(stream[:4], "big") <= 2048


def test_an_old_controller_is_read_by_its_other_port(tmp_path):
    with emulated("xarm", tmp_path, "--version", "xarm6-old") as emulation:
        with XArm(emulation.address) as driver:
            assert driver.read(1).position
        with pytest.raises(DriverError, match="too old for this port") as caught:
            XArm(f"{emulation.address}?port=30000")
    assert caught.value.reason is Reason.UNREACHABLE
    assert set(PORTS) == {30000, 30003}


def test_another_number_of_joints_is_refused(tmp_path):
    with emulated("xarm", tmp_path, "--version", "xarm5") as emulation:
        with XArm(emulation.address) as driver:
            assert len(driver.read(1).position) == 5
        told = pytest.raises(DriverError, match=r"has 5 joints, but the model has 6")
        with told as caught:
            XArm(emulation.address, [f"joint{i}" for i in range(1, 7)])
    assert caught.value.reason is Reason.WRONG_ROBOT

"""Universal Robots: what is asked for, and a controller that does not play along."""

import struct
import time

import pytest
from emulation import emulated
from listeners import saying

from mukca.drivers import DriverError, Reason
from mukca.drivers.rtde import encode_package, setup_payload, take_package
from mukca.drivers.ur import Ur


def test_packages_are_taken_one_by_one():
    stream = bytearray(encode_package(ord("M"), b"hello") + encode_package(ord("S"), b"\1"))
    half = stream[:5]
    assert take_package(half) is None
    assert take_package(stream) == (ord("M"), b"hello")
    assert take_package(stream) == (ord("S"), b"\1")
    assert take_package(stream) is None


@pytest.mark.parametrize("stream", [b"\0\2U", b"\0\7X1234", b"\xff\xffU"])
def test_what_is_no_package(stream):
    with pytest.raises(ValueError, match="a package of type"):
        take_package(bytearray(stream))


def test_the_request_for_outputs():
    names = b"timestamp,actual_q,robot_mode,safety_mode,target_moment"
    payload = setup_payload(500, "target_moment")
    assert payload == struct.pack(">d", 500.0) + names
    assert encode_package(ord("O"), payload)[:3] == struct.pack(">HB", 11 + len(names), ord("O"))


@pytest.mark.parametrize(("version", "rate"), [("3.15", 125), ("5.11", 500)])
def test_the_rate_is_the_controllers(version, rate, tmp_path):
    with emulated("ur", tmp_path, "--version", version) as emulation:
        with Ur(emulation.address) as driver:
            states = [driver.read(5) for _ in range(50)]
        assert states[-1].stamp - states[0].stamp == pytest.approx(49 / rate)
        with Ur(f"{emulation.address}?rate=25") as driver:
            states = [driver.read(5) for _ in range(10)]
            assert driver.missed == 0
        assert states[-1].stamp - states[0].stamp == pytest.approx(9 / 25)


def test_efforts_are_none_unless_an_output_is_asked_for(tmp_path):
    with emulated("ur", tmp_path, "--noise", "0") as emulation:
        with Ur(emulation.address) as driver:
            assert driver.read(5).effort is None
            assert driver.status == "running, normal"
        with Ur(f"{emulation.address}?effort=target_moment") as driver:
            state = driver.read(5)
        emulation.stop()
        assert list(state.effort) in [entry["effort"] for entry in emulation.sent().values()]


def test_an_output_that_the_controller_has_not(tmp_path):
    told = pytest.raises(DriverError, match="no output called actual_torque")
    with emulated("ur", tmp_path) as emulation, told as caught:
        Ur(f"{emulation.address}?effort=actual_torque")
    assert caught.value.reason is Reason.PROTOCOL


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        ((), Reason.BUSY),
        ((b"SSH-2.0-OpenSSH\r\n",), Reason.PROTOCOL),
        ((encode_package(ord("M"), b"\1a\1b\0"),), Reason.BUSY),  # texts without end
        ((encode_package(ord("V"), b"\0"),), Reason.PROTOCOL),
        ((encode_package(ord("V"), b"\1"), encode_package(ord("v"), b"5")), Reason.PROTOCOL),
    ],
)
def test_what_is_no_controller_is_told_in_time(texts, reason, monkeypatch):
    if reason is Reason.BUSY:  # which is told once the time is up
        monkeypatch.setattr("mukca.drivers.ur.CONNECT_SECONDS", 0.3)
    start = time.monotonic()
    with saying(*texts, pause=1e-4) as address, pytest.raises(DriverError) as caught:
        Ur(address)
    assert caught.value.reason is reason
    assert time.monotonic() - start < 15

"""Franka: the versions, the handshake with what is no robot, and the state in words."""

import struct
import time

import pytest
from emulation import emulated
from listeners import answering, fci_robot

from mukca.drivers import DriverError, JointState, Reason
from mukca.drivers.arms.franka import Franka
from mukca.drivers.arms.franka_state import decode_state
from mukca.tools.emulators.franka import encode_state

STATE = JointState(0.0, (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0))


@pytest.mark.parametrize("version", ["3", "4", "6", "7", "8", "9"])
def test_every_version_is_negotiated_and_reads_what_was_sent(version, tmp_path):
    with emulated("franka", tmp_path, "--version", version) as emulation:
        with Franka(emulation.address) as driver:
            states = [driver.read(5) for _ in range(20)]
        emulation.stop()
        sent = emulation.sent()
    for state in states:
        truth = sent[round(state.stamp * 1000)]
        assert state.position == tuple(truth["position"])
        assert state.effort == tuple(truth["effort"])


def test_a_version_can_be_demanded(tmp_path):
    with emulated("franka", tmp_path, "--version", "9") as emulation:
        with pytest.raises(DriverError, match="speaks version 9") as caught:
            Franka(f"{emulation.address}?version=5")
        with Franka(f"{emulation.address}?version=9") as driver:
            assert driver.read(5)
    assert caught.value.reason is Reason.PROTOCOL


def test_a_later_version_is_refused_with_what_can_be_read():
    refusal = struct.pack("<IIIBH", 0, 0, 15, 1, 11)
    with answering(refusal) as address, pytest.raises(DriverError) as caught:
        Franka(address)
    assert str(caught.value).endswith(
        "speaks version 11 of FCI and refused 5; versions 3 to 10 can be read here"
    )


@pytest.mark.parametrize("version", ["2", "11", "99999", "-1", "x"])
def test_a_version_that_nobody_speaks_is_a_bad_address(version):
    with pytest.raises(DriverError) as caught:
        Franka(f"127.0.0.1:9?version={version}")
    assert caught.value.reason is Reason.BAD_ADDRESS


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n", Reason.PROTOCOL),
        (bytes(12) + b"\7\5\0", Reason.PROTOCOL),  # a size of 0, and no such status
        (b"", Reason.BUSY),
        (b"\0\0\0", Reason.BUSY),  # and then silence
    ],
)
def test_what_is_no_robot_is_told(answer, reason, monkeypatch):
    if reason is Reason.BUSY:  # which is told once the time is up
        monkeypatch.setattr("mukca.drivers.arms.franka.CONNECT_SECONDS", 0.3)
    start = time.monotonic()
    with answering(answer) as address, pytest.raises(DriverError) as caught:
        Franka(address)
    assert caught.value.reason is reason
    assert time.monotonic() - start < 15


@pytest.mark.parametrize("version", [3, 5, 10])
def test_mode_and_errors_in_words(version):
    datagram = bytearray(encode_state(version, 1, STATE))
    count, tail = (37 if version < 5 else 41), (5 if version == 10 else 9)
    datagram[-tail] = 4
    datagram[-tail - 2 * count + 6] = 1  # among the current errors
    datagram[-tail - count + 3] = 1  # among those of the last motion, which are not told
    state = decode_state(bytes(datagram))
    assert (state.mode, state.errors) == ("reflex", ("joint reflex",))


def test_the_status_and_a_silence_tell_the_mode(tmp_path):
    silent = ("--fault", "silent@0.3")
    with emulated("franka", tmp_path, *silent) as emulation, Franka(emulation.address) as driver:
        assert driver.status == ""
        driver.read(5)
        assert driver.status == "guiding"
        with pytest.raises(DriverError, match="its last mode: guiding") as caught:
            while True:
                driver.read(0.3)
    assert caught.value.reason is Reason.SILENT


@pytest.mark.parametrize("forged", [2**63, 2**64 - 1, 10**7, 10_000])
def test_a_forged_number_costs_one_state(forged):
    datagrams = [encode_state(5, number, STATE) for number in (5, 6, forged, 7, 8, 4, 10)]
    with fci_robot(*datagrams) as address, Franka(address) as driver:
        stamps = [round(driver.read(1).stamp * 1000) for _ in range(5)]
        assert stamps == [5, 6, 7, 8, 10]
        assert (driver.missed, driver.rejected) == (1, 2)
        with pytest.raises(DriverError) as caught:
            driver.read(0.1)
    assert caught.value.reason is Reason.SILENT


def test_a_connection_that_is_ended_is_told_as_that(tmp_path):
    ended = pytest.raises(DriverError, match="took the connection, then ended it")
    with emulated("franka", tmp_path, "--fault", "busy") as emulation, ended as caught:
        Franka(emulation.address)
    assert caught.value.reason is Reason.BUSY
    with answering(b"\0\0\0") as address, pytest.raises(DriverError) as caught:
        Franka(address)
    assert "took the connection, then did not answer" in str(caught.value)

"""Franka: the versions, the handshake with what is no robot, and the state in words."""

import struct

import pytest
from driver_errors import refused
from emulation import emulated, reading
from listeners import answering, fci_robot, robot_state
from terminal_session import PATIENCE

from mukca import open_driver

pytestmark = pytest.mark.waits


@pytest.mark.parametrize("version", ["3", "4", "6", "7", "8", "9"])
def test_every_version_is_negotiated_and_reads_what_was_sent(version, tmp_path):
    with emulated("franka", tmp_path, "--version", version) as emulation:
        with open_driver("franka", emulation.address) as driver:
            states = [driver.read(5) for _ in range(20)]
        emulation.stop()
        sent = emulation.sent()
    for state in states:
        truth = sent[round(state.stamp * 1000)]
        assert state.position == tuple(truth["position"])
        assert state.effort == tuple(truth["effort"])


def test_a_version_can_be_demanded(tmp_path):
    with emulated("franka", tmp_path, "--version", "9") as emulation:
        with refused("PROTOCOL", match="speaks version 9"):
            open_driver("franka", f"{emulation.address}?version=5")
        with open_driver("franka", f"{emulation.address}?version=9") as driver:
            assert driver.read(5)


def test_a_later_version_is_refused_with_what_can_be_read():
    refusal = struct.pack("<IIIBH", 0, 0, 15, 1, 11)
    told = "speaks version 11 of FCI and refused 5; versions 3 to 10 can be read here, tried with "
    with answering(refusal) as address, refused("PROTOCOL", match=told):
        open_driver("franka", address)


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n", "PROTOCOL"),
        (bytes(12) + b"\7\5\0", "PROTOCOL"),  # a size of 0, and no such status
        (b"", "BUSY"),
    ],
)
def test_what_is_no_robot_is_told(answer, reason):
    with answering(answer) as address, refused(reason):
        open_driver("franka", address)


def test_the_status_and_a_silence_tell_the_mode(tmp_path):
    silent = ("--fault", "silent@0.3")
    with reading("franka", tmp_path, *silent) as (_, driver):
        assert driver.status == ""
        driver.read(5)
        assert driver.status == "guiding"
        with refused("SILENT", match="its last mode: guiding"):
            while True:
                driver.read(0.3)


@pytest.mark.parametrize("forged", [2**63, 2**64 - 1, 10**7, 10_000])
def test_a_forged_number_costs_one_state(forged):
    datagrams = [robot_state(number) for number in (5, 6, forged, 7, 8, 4, 10)]
    with fci_robot(*datagrams) as address, open_driver("franka", address) as driver:
        stamps = [round(driver.read(PATIENCE).stamp * 1000) for _ in range(5)]
        assert stamps == [5, 6, 7, 8, 10]
        assert (driver.missed, driver.rejected) == (1, 2)
        with refused("SILENT"):
            driver.read(0.1)


@pytest.mark.slow
def test_a_connection_that_is_ended_is_told_as_that(tmp_path):
    ended = refused("BUSY", match="took the connection, then ended it")
    with emulated("franka", tmp_path, "--fault", "busy") as emulation, ended:
        open_driver("franka", emulation.address)
    silent = refused("BUSY", match="took the connection, then did not answer")
    with answering(b"\0\0\0") as address, silent:
        open_driver("franka", address)

"""Kinova: angles without jumps, settings of the line, and kortex_api's absence and errors."""

import logging
import math
import os
import termios
import tty

import pytest
from cases import by_table
from driver_errors import reason_of, refused
from emulation import VirtualBus, emulated, reading
from kortex_stand_in import TORQUES, kortex_arm

from mukca import MukcaError, open_driver


def test_the_settings_of_the_line_are_in_the_address(tmp_path):
    """A pseudo-terminal has a rate, and no parity."""
    with emulated("kinova", tmp_path) as emulation:
        port = emulation.address.removeprefix("serial://").partition("?")[0]
        with open_driver("kinova", emulation.address):
            assert rate_of(port) == termios.B115200
        with open_driver("kinova", f"{emulation.address}&baud=921600"):
            assert rate_of(port) == termios.B921600


def rate_of(port):
    line = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        return termios.tcgetattr(line)[4]
    finally:
        os.close(line)


def test_joints_and_sign_are_settings(tmp_path):
    with emulated("kinova", tmp_path, "--noise", "0", "--hold", "60") as emulation:
        with open_driver("kinova", f"{emulation.address}&joints=4&effort=-1&rate=50") as driver:
            state = driver.read(5)
        emulation.stop()
        truth = emulation.sent()[1]
    assert state.position == pytest.approx(truth["position"][:4], abs=1e-6)
    assert state.effort == pytest.approx([-tau for tau in truth["effort"][:4]], abs=0.5)


def test_a_line_that_nobody_reads_holds_nobody_up(virtual_time):
    master, slave = os.openpty()
    tty.setraw(slave)
    start = virtual_time.now()
    for _ in range(3):
        with refused("UNREACHABLE"):
            open_driver("kinova", f"serial://{os.ttyname(slave)}?parity=none&joints=1")
    assert virtual_time.now() - start < 30
    os.close(master)
    os.close(slave)


def test_a_line_that_is_pulled_out_is_told(tmp_path):
    with reading("kinova", tmp_path) as (emulation, driver):
        driver.read(5)
        emulation.stop()
        with pytest.raises(MukcaError) as caught:
            for _ in range(100):
                driver.read(0.1)
    assert reason_of(caught.value) in ("UNREACHABLE", "SILENT")


def test_kortex_that_is_not_installed_says_how_to_get_it():
    with refused("MISSING_PACKAGE", match=r"github\.com/Kinovarobotics/kortex"):
        open_driver("kinova", "kortex://192.168.1.10")


@by_table("told", "truth")
def test_kortex_angles_are_centred_and_go_on_through_turns(told, truth):
    with kortex_arm() as arm, open_driver("kinova", f"{arm.address}?rate=1000") as driver:
        angles = []
        for degrees in told:
            arm.degrees = [degrees] * 7
            state = driver.read(1)
            angles.append(math.degrees(state.position[1]))
    assert angles == pytest.approx(truth)
    assert state.effort == TORQUES


@pytest.mark.parametrize(("number", "told"), [("GS1904", "serial number GS1904"), ("", "")])
def test_kortex_arms_are_known_by_their_serial_numbers(number, told):
    """One that tells none is read all the same."""
    with kortex_arm() as arm:
        arm.serial_number = number
        with open_driver("kinova", arm.address) as driver:
            assert driver.identity == told and driver.read(1).position


def test_kortex_logs_in_as_told():
    with kortex_arm() as arm, open_driver("kinova", f"{arm.address}?user=me&password=secret"):
        assert (arm.login.username, arm.login.password) == ("me", "secret")


@pytest.mark.parametrize(
    ("failure", "reason"),
    [(TimeoutError(), "SILENT"), (RuntimeError("session ended"), "UNREACHABLE")],
)
def test_kortex_errors(failure, reason):
    with kortex_arm() as arm, open_driver("kinova", arm.address) as driver:
        arm.failure = failure
        with refused(reason):
            driver.read(1)
        arm.failure = None
        if reason == "SILENT":
            assert driver.read(1)


def test_kortex_numbers_that_are_none_are_asked_for_again():
    with kortex_arm() as arm, open_driver("kinova", arm.address) as driver:
        arm.degrees = [math.nan, 0.0]
        with refused("SILENT", match="answers without numbers"):
            driver.read(0.3)
        assert driver.rejected > 0


def test_a_lost_bus_is_told(tmp_path):
    with emulated("kinova", tmp_path, "--version", "can") as emulation:
        driver = open_driver("kinova", emulation.address)
        driver.read(1)
        VirtualBus.network_is_down = True
        with driver, refused("UNREACHABLE", match="is lost: Network is down"):
            driver.read(1)


def test_what_isotp_logs_stays_off_the_screen(tmp_path):
    with reading("kinova", tmp_path, "--version", "can") as (_, driver):
        driver.read(1)
    assert logging.getLogger("isotp").handlers

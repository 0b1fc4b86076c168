"""Kinova: angles without jumps, settings of the line, and kortex_api's absence and errors."""

import math
import os
import time
import tty

import pytest
import serial
from emulation import VirtualBus, emulated
from kortex_stand_in import TORQUES, kortex_arm

from mukca.drivers import DriverError, Reason, clock, open_driver
from mukca.drivers.arms.kinova.actuator_messages import decode_reply, encode_poll
from mukca.drivers.arms.kinova.kinova import Kinova, Unwrap


def test_the_polls_bytes():
    assert encode_poll(0x13) == bytes.fromhex("0100 00 13" + 16 * "00")


def test_a_reply_in_degrees():
    reply = decode_reply(bytes.fromhex("0200 13 00 0000003f 0000b4c2 00000000 000040c0"), 0x13)
    assert (reply.degrees, reply.torque) == (-90.0, -3.0)


def test_unwrapping_takes_out_whole_turns_alone():
    unwrap = Unwrap(centred=False)
    path = [350.0, 359.0, 2.0, 10.0, 359.5, 350.0]
    angles = [math.degrees(unwrap([degrees])[0]) for degrees in path]
    assert angles == pytest.approx([350.0, 359.0, 362.0, 370.0, 359.5, 350.0])


def test_unwrapping_over_many_turns():
    unwrap = Unwrap(centred=True)
    truth = [20.0 * step for step in range(100)]
    angles = [math.degrees(unwrap([angle % 360])[0]) for angle in truth]
    assert angles == pytest.approx(truth)


@pytest.mark.parametrize(
    ("centred", "first", "expected"),
    [(True, 350.0, -10.0), (True, 170.0, 170.0), (False, 350.0, 350.0)],
)
def test_the_first_angle(centred, first, expected):
    assert math.degrees(Unwrap(centred)([first])[0]) == pytest.approx(expected)


class OpenedError(Exception):
    """Stands for a port, opened with these settings."""


def test_every_setting_of_the_line_is_in_the_address(monkeypatch):
    def opened(*place, **settings):
        raise OpenedError(place, settings)

    monkeypatch.setattr(serial, "Serial", opened)
    with pytest.raises(OpenedError) as caught:
        Kinova("serial:///dev/ttyUSB3?baud=921600&parity=odd&stopbits=1.5&databits=7")
    place, settings = caught.value.args
    assert place == ("/dev/ttyUSB3", 921600)
    assert settings["parity"] == serial.PARITY_ODD
    assert (settings["stopbits"], settings["bytesize"]) == (1.5, 7)
    with pytest.raises(OpenedError) as caught:
        Kinova("serial:///dev/ttyACM1")
    place, settings = caught.value.args
    assert (place[1], settings["parity"], settings["stopbits"]) == (115200, "E", 2)


@pytest.mark.parametrize(
    "address",
    [
        "",
        "/dev/ttyUSB0",
        "usb://1",
        "serial://",
        "serial:///dev/null?parity=maybe",
        "serial:///dev/null?baud=quick",
        "serial:///dev/null?spedd=1",
        "can://can0?tx=one",
        "kortex://",
        "kortex://host?rate=0",
    ],
)
def test_addresses_that_mean_nothing(address):
    with pytest.raises(DriverError) as caught:
        Kinova(address)
    assert caught.value.reason is Reason.BAD_ADDRESS


def test_joints_and_sign_are_settings(tmp_path):
    with emulated("kinova", tmp_path, "--noise", "0", "--hold", "60") as emulation:
        with Kinova(f"{emulation.address}&joints=4&effort=-1&rate=50") as driver:
            state = driver.read(5)
        emulation.stop()
        truth = emulation.sent()[1]
    assert state.position == pytest.approx(truth["position"][:4], abs=1e-6)
    assert state.effort == pytest.approx([-tau for tau in truth["effort"][:4]], abs=0.5)


def test_an_actuator_that_is_not_there_is_named(tmp_path):
    told = pytest.raises(DriverError, match="actuator 0x16")
    with emulated("kinova", tmp_path) as emulation, told as caught:
        Kinova(f"{emulation.address}&joints=7")
    assert caught.value.reason is Reason.UNREACHABLE


def test_a_line_that_nobody_reads_holds_nobody_up(virtual_time):
    master, slave = os.openpty()
    tty.setraw(slave)
    start = clock.now()
    for _ in range(3):
        with pytest.raises(DriverError) as caught:
            Kinova(f"serial://{os.ttyname(slave)}?parity=none&joints=1")
        assert caught.value.reason is Reason.UNREACHABLE
    assert clock.now() - start < 30
    os.close(master)
    os.close(slave)


def test_a_line_that_is_pulled_out_is_told(tmp_path):
    with emulated("kinova", tmp_path) as emulation, Kinova(emulation.address) as driver:
        driver.read(5)
        emulation.stop()
        with pytest.raises(DriverError) as caught:
            for _ in range(100):
                driver.read(0.1)
    assert caught.value.reason in (Reason.UNREACHABLE, Reason.SILENT)


def test_kortex_that_is_not_installed_says_how_to_get_it():
    with pytest.raises(DriverError, match=r"github\.com/Kinovarobotics/kortex") as caught:
        Kinova("kortex://192.168.1.10")
    assert caught.value.reason is Reason.MISSING_PACKAGE


def test_kortex_angles_are_centred_and_unwrapped():
    with kortex_arm() as arm:
        arm.degrees = [350.0, 10.0, 180.5]
        with Kinova(arm.address) as driver:
            state = driver.read(1)
            assert [math.degrees(q) for q in state.position] == pytest.approx([-10, 10, -179.5])
            assert state.effort == TORQUES[:3]
            arm.degrees = [5.0, 359.0, 179.0]
            angles = [math.degrees(q) for q in driver.read(1).position]
    assert angles == pytest.approx([5, -1, -181])


def test_kortex_logs_in_as_told():
    with kortex_arm() as arm, Kinova(f"{arm.address}?user=me&password=secret"):
        assert (arm.login.username, arm.login.password) == ("me", "secret")


@pytest.mark.parametrize(
    ("failure", "reason"),
    [(TimeoutError(), Reason.SILENT), (RuntimeError("session ended"), Reason.UNREACHABLE)],
)
def test_kortex_errors(failure, reason):
    with kortex_arm() as arm, Kinova(arm.address) as driver:
        arm.failure = failure
        with pytest.raises(DriverError) as caught:
            driver.read(1)
        assert caught.value.reason is reason
        arm.failure = None
        if reason is Reason.SILENT:
            assert driver.read(1)


def test_kortex_numbers_that_are_none_are_asked_for_again():
    with kortex_arm() as arm, Kinova(arm.address) as driver:
        arm.degrees = [math.nan, 0.0]
        start = time.monotonic()
        with pytest.raises(DriverError, match="sends no numbers") as caught:
            driver.read(0.3)
        assert time.monotonic() - start < 5
        assert driver.rejected > 0
    assert caught.value.reason is Reason.SILENT


def test_a_lost_bus_is_told(tmp_path):
    with emulated("kinova", tmp_path, "--version", "can") as emulation:
        driver = open_driver("kinova", emulation.address)
        driver.read(1)
        VirtualBus.network_is_down = True
        with driver, pytest.raises(DriverError, match="bus is lost: Network is down") as caught:
            driver.read(1)
    assert caught.value.reason is Reason.UNREACHABLE

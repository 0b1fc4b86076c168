"""Damiao motors: what must stop a recording, what is told, and settings of the address."""

from contextlib import contextmanager

import pytest
from driver_errors import refused
from emulation import emulated, reading

from mukca import open_driver
from mukca.drivers import Reconnecting, clock
from mukca.drivers.transport import CanBus, parse_can_address


def test_what_troubles_a_motor_is_told_and_an_enabled_one_refused(tmp_path):
    with emulated("damiao", tmp_path) as emulation:
        emulation.emulator.status = 9
        with open_driver("damiao", f"{emulation.address}&ids=2,3") as driver:
            driver.read(1)
            assert driver.status == "motor 2: under-voltage, motor 3: under-voltage"
            emulation.emulator.status = 1
            with refused("WRONG_MODE", match="is enabled: end the program"):
                driver.read(1)


def test_motors_are_known_by_their_serial_numbers(tmp_path):
    with reading("damiao", tmp_path, settings="&ids=1,3") as (_, driver):
        assert driver.identity == "serial numbers 20260001, 20260003"


def test_another_arm_on_the_bus_is_not_gone_on_with(tmp_path):
    with emulated("damiao", tmp_path) as emulation:
        connect = lambda: open_driver("damiao", emulation.address)  # noqa: E731
        with Reconnecting(connect, first_wait=0.0) as driver:
            driver.read(1)
            emulation.emulator.status = 1  # it is switched on, and another arm comes after it
            with refused("SILENT", match="is enabled"):
                driver.read(1)
            emulation.emulator.status, emulation.emulator.first_serial = 0, 7
            with refused("WRONG_ROBOT", match="its marks are serial numbers 8, 9"):
                driver.read(1)


@contextmanager
def read_beside(folder):
    """An arm of which another program reads too: the arm, our driver, and what sends its frames."""
    with emulated("damiao", folder, "--hold", "0") as emulation:
        other = CanBus(parse_can_address(emulation.address))
        with open_driver("damiao", emulation.address) as driver:
            yield emulation, driver, other.send
        other.close()


def test_a_register_that_another_program_asked_for_is_no_feedback(tmp_path):
    with read_beside(tmp_path) as (_, driver, send):
        for number in range(100):
            motor = 1 + number % 7
            for register in (0x33, 0x55, 0xAA):  # read, written, saved
                clock.sleep(0.002)
                send(0x10 + motor, bytes([motor, 0, register, 0x15, 0, 0, 0x48, 0x41]))
            assert max(map(abs, driver.read(1).position)) < 3


def test_feedback_that_another_program_asked_for_is_not_taken_for_later_one(tmp_path):
    with read_beside(tmp_path) as (emulation, driver, send):
        states = []
        for _ in range(100):
            for motor in range(1, 8):
                send(0x7FF, bytes([motor, 0, 0xCC, 0, 0, 0, 0, 0]))
            clock.sleep(0.05)
            states.append(driver.read(1))
        sent = list(emulation.sent().values())
    for state in states:
        near = [told for told in sent if abs(told["at"] - state.stamp) < 0.02]
        assert any(abs(told["position"][0] - state.position[0]) < 2e-4 for told in near)


def test_a_query_that_is_answered_late_gives_no_angle(tmp_path):
    """The answers to two queries come together, once the line no longer stalls."""
    with reading("damiao", tmp_path, "--fault", "stall@0+0.15", settings="&ids=1") as (_, driver):
        for _ in range(20):
            assert max(map(abs, driver.read(1).position)) < 3
        assert driver.rejected == 0


def test_motors_and_signs_are_settings(tmp_path):
    with emulated("damiao", tmp_path, "--noise", "0", "--hold", "60") as emulation:
        with open_driver("damiao", f"{emulation.address}&ids=1,3&signs=1,-1") as driver:
            position = driver.read(1).position
        truth = emulation.sent()[1]["position"]
    assert position == pytest.approx((truth[0], -truth[2]), abs=2e-4)

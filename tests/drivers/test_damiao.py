"""Damiao motors: what must stop a recording, what is told, and settings of the address."""

import pytest
from driver_errors import refused
from emulation import emulated

from mukca import open_driver


def test_an_enabled_motor_is_refused(tmp_path):
    with emulated("damiao", tmp_path) as emulation:
        driver = open_driver("damiao", emulation.address)
        driver.read(1)
        emulation.emulator.status = 1
        with driver, refused("WRONG_MODE", match="is enabled: end the program"):
            driver.read(1)


def test_what_troubles_a_motor_is_told(tmp_path):
    with emulated("damiao", tmp_path) as emulation:
        emulation.emulator.status = 9
        with open_driver("damiao", f"{emulation.address}&ids=2,3") as arm:
            arm.read(1)
            assert arm.status == "motor 2: under-voltage, motor 3: under-voltage"


def test_another_scale_is_refused(tmp_path):
    told = refused("WRONG_ROBOT", match=r"motor 1 on .* counts to 3\.14159 rad, not 12\.5")
    with emulated("damiao", tmp_path) as emulation, told:
        emulation.emulator.pmax = 3.14159
        open_driver("damiao", emulation.address)


def test_motors_and_signs_are_settings(tmp_path):
    with emulated("damiao", tmp_path, "--noise", "0", "--hold", "60") as emulation:
        with open_driver("damiao", f"{emulation.address}&ids=1,3&signs=1,-1") as driver:
            position = driver.read(1).position
        truth = emulation.sent()[1]["position"]
    assert position == pytest.approx((truth[0], -truth[2]), abs=2e-4)


@pytest.mark.parametrize("words", ["ids=0", "ids=1,16", "ids=a", "signs=1,1", "signs=2", "rate=0"])
def test_settings_that_mean_nothing(words):
    with refused("BAD_ADDRESS"):
        open_driver("damiao", f"virtual/x?{words}")

"""Servos on a line: zeros, what must stop a recording, and what is told."""

import json
import math

import pytest
from cases import by_table
from driver_errors import refused
from emulation import emulated

from mukca import open_driver

TICK = 2 * math.pi / 4096


def so101(tmp_path, **changes):
    """Write a calibration file of lerobot's and return its path."""
    names = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
    motors = {
        name: {"id": number, "drive_mode": 0, "homing_offset": 0, "range_min": 500 + 100 * number,
               "range_max": 3500}
        for number, name in enumerate(names, 1)
    }  # fmt: skip
    for name, change in changes.items():
        motors[name] |= change
    path = tmp_path / "my arm.json"
    path.write_text(json.dumps(motors))
    return path


def read_first(address):
    with open_driver("feetech", address) as driver:
        return driver.read(1).position


def test_where_the_zero_is(tmp_path):
    with emulated("feetech", tmp_path, "--noise", "0") as emulation:
        plain = read_first(emulation.address)
        turned = read_first(
            f"{emulation.address}?signs=1,-1.0,1,1,1&zeros=2048,2048,1024,2048,2048"
        )
        by_file = read_first(f"{emulation.address}?calibration={so101(tmp_path)}")
        of_so100 = read_first(f"{emulation.address}?arm=so100")
        fewer = read_first(f"{emulation.address}?ids=2,3")
    assert turned == pytest.approx(
        (plain[0], -plain[1], plain[2] + math.pi / 2, plain[3], plain[4])
    )
    middles = [2050, 2100, 2150, 2200, 2250]
    shifts = [q - p for q, p in zip(by_file, plain, strict=True)]
    assert shifts == pytest.approx([(2048 - middle) * TICK for middle in middles])
    shifts = [math.degrees(q - p) for q, p in zip(of_so100, plain, strict=True)]
    assert shifts == pytest.approx([0, 100.268, -90, -37.242, 0])
    assert fewer == plain[1:3]


def test_a_servo_that_was_homed_anew_is_refused(tmp_path):
    path = so101(tmp_path, elbow_flex={"homing_offset": -50})
    told = refused("WRONG_ROBOT", match=r"at elbow_flex have another homing")
    with emulated("feetech", tmp_path) as emulation, told:
        open_driver("feetech", f"{emulation.address}?calibration={path}")


def test_servos_are_known_by_their_homing_offsets(tmp_path):
    with (
        emulated("feetech", tmp_path) as emulation,
        open_driver("feetech", emulation.address) as driver,
    ):
        assert driver.identity == "homing offsets 0, 0, 0, 0, 0"


def test_a_model_that_is_told_once_is_not_believed(tmp_path):
    """A late position looks like a model number."""

    class Model:
        told = 0

        def to_bytes(self, size, order):
            self.told += 1
            return (2100 if self.told <= 2 * 5 else 777).to_bytes(size, order)

    with emulated("feetech", tmp_path) as emulation:
        emulation.emulator.model = Model()
        with open_driver("feetech", emulation.address) as driver:
            assert driver.read(1)


def test_a_position_beyond_the_turn_is_no_state(tmp_path):
    told = refused("SILENT", match="position -12 of servo 4, beyond its turn")
    with emulated("feetech", tmp_path) as emulation:
        emulation.emulator.turned = {4: -12}
        with open_driver("feetech", emulation.address) as driver, told:
            driver.read(0.5)
    assert driver.rejected > 10


def test_what_troubles_a_servo_is_told(tmp_path):
    with emulated("feetech", tmp_path) as emulation:
        emulation.emulator.errors = {2: 0x24}
        with open_driver("feetech", emulation.address) as driver:
            assert driver.read(1).position
            assert driver.status == "shoulder_lift: too hot, shoulder_lift: overload"


@by_table("text")
def test_what_is_no_calibration_file(text, tmp_path):
    path = tmp_path / "arm.json"
    path.write_text(text)
    with refused("BAD_ADDRESS", match=r"arm\.json"):
        open_driver("feetech", f"/dev/null?calibration={path}")

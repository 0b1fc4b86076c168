"""UFACTORY: old controllers, other numbers of joints, and the status in words."""

import pytest
from driver_errors import refused
from emulation import emulated, reading

from mukca import open_driver


def test_an_old_controller_is_read_by_its_other_port(tmp_path):
    with emulated("xarm", tmp_path, "--version", "xarm6-old") as emulation:
        with open_driver("xarm", emulation.address) as driver:
            assert driver.read(1).position
            assert driver.status == "joint teaching, ready"
        with refused("UNREACHABLE", match="too old for this port"):
            open_driver("xarm", f"{emulation.address}?port=30000")


@pytest.mark.parametrize("version", ["xarm6", "xarm6-old"])
def test_an_arm_is_known_by_its_type_and_software(tmp_path, version):
    with reading("xarm", tmp_path, "--version", version) as (_, driver):
        assert driver.identity == "type 6, software v2.6.0"


def test_stamps_are_the_controllers(tmp_path):
    with emulated("xarm", tmp_path) as emulation:
        driver = open_driver("xarm", emulation.address)
        stamps = [driver.read(1).stamp for _ in range(50)]
        driver.close()
    assert stamps[0] == pytest.approx(5.004)
    assert stamps[-1] - stamps[0] == pytest.approx(49 / 250)


def test_another_number_of_joints_is_refused(tmp_path):
    with emulated("xarm", tmp_path, "--version", "xarm5") as emulation:
        with open_driver("xarm", emulation.address) as driver:
            assert len(driver.read(1).position) == 5
        told = refused("WRONG_ROBOT", match=r"has 5 joints, but the model has 6")
        with told:
            open_driver("xarm", emulation.address, [f"joint{i}" for i in range(1, 7)])

"""The list of shipped models: every one, with what reads it and where its numbers are from."""

import json

import pytest

from mukca.drivers.arms.servos.joint_maps import ARMS
from mukca.drivers.registry import DRIVERS
from mukca.solver.robot import load_robot, shipped_robots
from mukca.tools.cli import main


@pytest.fixture(scope="module")
def robots():
    with pytest.MonkeyPatch.context() as patch:
        printed = []
        patch.setattr("sys.stdout.write", printed.append)
        assert main(["robots", "--json"]) == 0
    return {row["name"]: row for row in json.loads("".join(printed))["robots"]}


@pytest.mark.slow
def test_every_shipped_robot_is_listed(robots):
    assert list(robots) == list(shipped_robots())
    for name, row in robots.items():
        assert row["title"] and "\n" not in row["title"]
        assert row["joints"] == len(load_robot(name).actuated)
        assert len(row["source"]) > 20


def test_each_is_read_by_a_driver_that_is_there(robots):
    for name, row in robots.items():
        driver, _, address = row["driver"].partition(":")
        assert driver in DRIVERS and address
        if "arm=" in address:
            assert len(ARMS[address.partition("arm=")[2]].ids) == robots[name]["joints"]


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("ur5e", 0.95, 1.05), ("panda", 0.9, 1.05), ("so101", 0.38, 0.5), ("xarm7", 0.75, 0.9)],
)
def test_the_reach_is_about_the_data_sheets(robots, name, low, high):
    """Plus the ball beyond the flange: 850, 855, 700 mm; 225 + 100 mm and a gripper of 100."""
    assert low < robots[name]["reach"] < high


@pytest.mark.slow
def test_for_people(capsys):
    assert main(["robots"]) == 0
    shown = capsys.readouterr().out
    assert "so101      TheRobotStudio SO-101\n" in shown
    assert "5 joints, reach 0.4" in shown
    assert "feetech:PORT?arm=so101" in shown

"""The list of shipped models: every one, with what reads it and where its numbers are from."""

import io
import json
import re
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]


def listed(what):
    with redirect_stdout(io.StringIO()) as printed:
        assert main([what, "--json"]) == 0
    return {row["name"]: row for row in json.loads(printed.getvalue())[what]}


@pytest.fixture(scope="module")
def robots():
    return listed("robots")


def test_every_shipped_robot_is_described(robots):
    assert len(robots) > 20
    for name, row in robots.items():
        assert row["title"] and "\n" not in row["title"]
        assert row["joints"] == len(mukca.load_robot(name).actuated)
        assert len(row["source"]) > 20
        assert row["sources"][0].endswith(row["source"]) and "licences" in row


def test_a_model_made_of_a_file_is_listed_with_its_licence(robots, command):
    assert robots["ur5"]["licences"] == ["BSD-3-Clause"] and robots["piper"]["licences"] == ["MIT"]
    status, out, _ = command("robots", "--licences")
    assert status == 0 and "C. Gaz, M. Cognetti" in out


def test_each_is_read_by_a_driver_that_is_there(robots):
    drivers = listed("drivers")
    for row in robots.values():
        driver, _, address = row["driver"].partition(":")
        assert driver in drivers and address


def test_the_readme_names_each_with_its_driver(robots):
    rows = re.findall(r"^\| (`.*`) \| \[?`(\w+)`", (ROOT / "README.md").read_text(), re.M)
    listed = {name: driver for names, driver in rows for name in re.findall(r"`(\w+)`", names)}
    assert listed == {name: row["driver"].partition(":")[0] for name, row in robots.items()}


def test_for_people(command):
    _, shown, _ = command("robots")
    assert "so101      TheRobotStudio SO-101\n" in shown
    assert "5 joints, reach 0.4" in shown
    assert "feetech:PORT?arm=so101" in shown

"""A calibration of every shipped robot, with every correction, made without any fit."""

import io
import json
from contextlib import redirect_stdout
from functools import lru_cache, partial

import pytest
from imagined import imagine

import mukca
from mukca.tools.cli import main


def shipped():
    with redirect_stdout(io.StringIO()) as out:
        main(["robots", "--json"])
    return [robot["name"] for robot in json.loads(out.getvalue())["robots"]]


ROBOTS = shipped()


@pytest.fixture(scope="session")
def calibrations(session, shared):
    """A folder with ROBOT.json for every shipped robot; nobody writes there."""

    def make(folder):
        panda = mukca.load_robot("panda")
        fitted = mukca.calibrate(panda, mukca.read_placements(session / "front"), method="paper")
        folder.mkdir()
        fitted.save(folder / "fitted")
        text = (folder / "fitted" / "calibration.json").read_text()
        (folder / "fitted.json").write_text(text)
        for name in ROBOTS:
            document = imagine(mukca.load_robot(name), json.loads(text))
            (folder / f"{name}.json").write_text(json.dumps(document))

    return shared("exports", make)


@pytest.fixture(params=ROBOTS)
def imagined(request, calibrations):
    """The file of one robot's calibration, and the calibration; robot after robot."""
    file = calibrations / f"{request.param}.json"
    return file, loaded(file)


loaded = lru_cache(maxsize=None)(mukca.load_calibration)


@pytest.fixture
def export(command):
    """Run `mukca export`: status, output, error."""
    return partial(command, "export")

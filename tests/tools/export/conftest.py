"""A calibration of every shipped robot, with every extension, made without any fit."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

import mukca
from mukca.solver.bayes.model import EXTENSIONS, coefficient_names
from mukca.solver.calibration import Calibration, load_calibration
from mukca.solver.results import CalibrationDocument, PlacementSamples, RecordedSample, encode
from mukca.solver.robot import Robot, choose_parameters, load_robot, shipped_robots, workspace
from mukca.tools.cli import main

ROBOTS = tuple(shipped_robots())


def imagine(robot: Robot, template: CalibrationDocument, seed: int = 0) -> CalibrationDocument:
    """Return a calibration of a robot: every number off, all joints corrected."""
    rng = np.random.default_rng([seed, len(robot.joints)])
    by_name = {value.component: value for value in template.parameters}
    values = []
    for parameter in choose_parameters(robot):
        nominal = float(robot.origins.ravel()[parameter.index])
        off, other = rng.normal(0, 2e-3, 2).tolist()
        values.append(
            msgspec.structs.replace(
                by_name[parameter.component],
                name=parameter.name,
                joint=parameter.joint,
                nominal=nominal,
                calibrated=nominal + off,
                change=off,
                exported=nominal + off + 0.1 * other,
            )
        )
    sizes = {e: len(coefficient_names(e, robot.joint_names)) for e in EXTENSIONS}
    deflection = {e: tuple(rng.uniform(0, 2e-5, size).tolist()) for e, size in sizes.items()}
    samples = tuple(
        RecordedSample(socket=i % 2, position=tuple(q), effort=None)
        for i, q in enumerate(workspace(robot, 20).tolist())
    )
    data = PlacementSamples(name="a/b", role="train", distance=0.05, files=(), samples=samples)
    model = msgspec.structs.replace(
        template.model,
        name=robot.name,
        source=robot.source,
        base=robot.base,
        tip=robot.tip,
        joint_names=robot.joint_names,
        nominal_urdf=robot.text.data.decode(),
    )
    return msgspec.structs.replace(
        template, parameters=tuple(values), deflection=deflection, data=(data,), model=model
    )


@pytest.fixture(scope="session")
def calibrations(session: Path, shared: Callable[..., Path]) -> Path:
    """A folder with ROBOT.json for every shipped robot; nobody writes there."""

    def make(folder: Path) -> None:
        robot = load_robot("panda")
        fitted = mukca.calibrate(robot, mukca.read_placements(session / "front"), method="paper")
        folder.mkdir()
        (folder / "fitted.json").write_bytes(encode(fitted.document))
        for name in ROBOTS:
            document = imagine(load_robot(name), fitted.document)
            (folder / f"{name}.json").write_bytes(encode(document))

    return shared("exports", make)


@pytest.fixture(params=ROBOTS)
def imagined(request: pytest.FixtureRequest, calibrations: Path) -> tuple[Path, Calibration]:
    """The file of one robot's calibration, and the calibration; robot after robot."""
    file = calibrations / f"{request.param}.json"
    return file, loaded(file)


loaded = lru_cache(maxsize=None)(load_calibration)


@pytest.fixture
def export(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run `mukca export`: status, output, error."""

    def run(*words: object) -> tuple[int, str, str]:
        try:
            status = main(["export", *map(str, words)])
        except SystemExit as stop:
            status = int(stop.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return run

"""What tests share: where real recordings are, and small simulated ones."""

import os

# As the command line does, before NumPy is loaded: the matrices here are small.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from mukca.recorder.convert import write_holes
from mukca.solver.robot.urdf import Robot, load_robot
from mukca.tools.simulate import Base, perturb, record

ROOT = Path(__file__).parents[1]

# A loaded machine is no failure.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--hardware",
        action="append",
        default=[],
        metavar="NAME=ADDRESS",
        help="run the drivers' contract on a robot, as in franka=172.16.0.2; may be repeated",
    )


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Recordings of real arms, which stand beside the project or not at all."""
    folder = ROOT.parent / "shared" / "recordings"
    if not folder.is_dir():
        pytest.skip(f"no recordings of real arms at {folder}")
    return folder


@pytest.fixture(scope="session")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="session")
def true_panda(panda: Robot) -> Robot:
    """A Panda whose true kinematics differ from its URDF."""
    return perturb(panda, np.random.default_rng(7), 2e-3, 5e-3)


@pytest.fixture(scope="session")
def session(true_panda: Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with three placements of that arm, 2 x 12 samples each."""
    folder = tmp_path_factory.mktemp("session")
    generator = np.random.default_rng(8)
    along_y = np.array([0.0, 1.0, 0.0])
    for name, x, y in (("front", 0.5, 0.0), ("left", 0.35, 0.4), ("right", 0.35, -0.4)):
        base = Base(name, np.array([x, y, 0.1]), along_y)
        placement = record(true_panda, base, generator, samples=12, noise=5e-5)
        write_holes(placement, folder / name)
    return folder

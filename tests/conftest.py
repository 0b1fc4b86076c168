"""What tests share: where real recordings are, and small simulated ones."""

import fcntl
import gc
import json
import os
import shutil
import signal

# As the command line does, before NumPy is loaded: the matrices here are small.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_TRACEBACK", "1")  # a defect shows itself
# Each calibration of a test tells whether its covariances are covariances.
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from calibrated_arm import simulate
from hypothesis import settings
from recorded import RIGID, true_arm, write_session
from virtual_time import VirtualTime

import mukca
from mukca.tools.cli import main

ROOT = Path(__file__).parents[1]

# A shell's background ignores these, and so would every program that a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGQUIT, signal.SIG_DFL)

# Programs that tests start see what users have: no variable of Python's but where packages are.
for name in [name for name in os.environ if name.startswith("PYTHON")]:
    if name != "PYTHONPATH":
        del os.environ[name]

# A loaded machine is no failure.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")


def pytest_addoption(parser):
    parser.addoption(
        "--hardware",
        action="append",
        default=[],
        metavar="NAME=ADDRESS",
        help="run the drivers' contract on a robot, as in franka=172.16.0.2; may be repeated",
    )


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no garbage among thousands of tests, now or later: that takes long."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Let the first process that comes to a module compile it for all: one does the work."""
    if not isinstance(collector, pytest.Module):
        return (yield)
    with collector.path.open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return (yield)


LONG = ("tools/test_insertion.py", "tools/test_emulated_arms.py", "recorder/test_kill.py")


def pytest_collection_modifyitems(items):
    """Begin with what waits in real time, while the other processes compute; then what is long."""
    items.sort(
        key=lambda item: (
            item.get_closest_marker("waits") is None,
            not item.path.as_posix().endswith(LONG),
        )
    )


@pytest.fixture
def virtual_time():
    """A clock that goes on when everybody in this process waits."""
    with VirtualTime().running() as time:
        yield time


@pytest.fixture(scope="session")
def shared(tmp_path_factory, worker_id):
    """Return a folder by name, made by the first of all test processes that asks for it."""
    base = tmp_path_factory.getbasetemp()
    base = base if worker_id == "master" else base.parent

    def shared(name, make):
        folder, done = base / name, base / f"{name}.done"
        with (base / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not done.exists():
                make(folder)
                done.touch()
        return folder

    return shared


@pytest.fixture
def command(capsys):
    """Run `mukca` with words in this process: status, output, error."""

    def run(*words):
        capsys.readouterr()  # what was said before
        try:
            status = main([*map(str, words)])
        except SystemExit as stop:  # argparse's own refusals
            status = int(stop.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return run


@pytest.fixture
def refused(command):
    """Run `mukca` with words that it refuses by one line, which tells why; return the line."""

    def refused(told, *words):
        status, out, err = command(*words)
        assert (status, out, err.count("\n")) == (2, "", 1) and told in err, err
        return err

    return refused


@pytest.fixture
def answer(command):
    """Run `mukca` with words and `--json`; return its answer after the status was compared."""

    def answer(*words, status=0):
        found, out, err = command(*words, "--json")
        assert found == status, err
        return json.loads(out)

    return answer


@pytest.fixture(scope="session")
def recordings():
    """Recordings of real arms, which stand beside the project or not at all."""
    folder = ROOT.parent / "shared" / "recordings"
    if not folder.is_dir():
        pytest.skip(f"no recordings of real arms at {folder}")
    return folder


@pytest.fixture(scope="session")
def ur10_points():
    """The file of points of a UR10 that a laser tracker measured."""
    file = ROOT.parent / "shared/tracker/ur10/points.csv"
    return file if file.is_file() else pytest.skip(f"no points of a laser tracker at {file}")


@pytest.fixture(scope="session")
def panda():
    return mukca.load_robot("panda")


@pytest.fixture(scope="session")
def chromium():
    """A browser without a window."""
    playwright = pytest.importorskip("playwright.sync_api")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no chromium: apt-get install chromium")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with playwright.sync_playwright() as player:
        browser = player.chromium.launch(executable_path=program, args=options)
        yield browser
        browser.close()


@pytest.fixture
def tab(chromium):
    """A page of it."""
    with chromium.new_page() as tab:
        yield tab


@pytest.fixture(scope="session")
def true_panda(panda):
    """A Panda whose true kinematics differ from its URDF."""
    return true_arm(panda, np.random.default_rng(7))


@pytest.fixture(scope="session")
def simulated():
    return simulate()


@pytest.fixture(scope="session")
def cal(simulated, shared):
    """A folder with the calibration of that arm; nobody writes there."""
    return shared("cal", simulated.calibration.save)


@pytest.fixture(scope="session")
def ur5e():
    """The calibration of a UR5e."""
    robot = mukca.load_robot("ur5e")
    _, placements = mukca.simulate_recordings(robot, 2, seed=2, samples=12)
    return mukca.calibrate(robot, placements, **RIGID)


@pytest.fixture(scope="session")
def curved(shared):
    """The calibration of a UR5e with joint error curves, the placements trained on, and another."""
    robot = mukca.load_robot("ur5e")
    _, (*train, later) = mukca.simulate_recordings(robot, 3, samples=15, seed=2, curves=5e-4)

    def make(folder):
        others = ("compliance", "tilt", "transmission")
        mukca.calibrate(robot, train, without=others).save(folder)

    return mukca.load_calibration(shared("curved", make)), train, later


@pytest.fixture(scope="session")
def session(true_panda, shared):
    """A folder with three placements of that arm, 2 x 12 samples each; nobody writes there."""
    return shared("session", lambda folder: write_session(folder, true_panda))


@pytest.fixture(scope="session")
def demo(shared):
    """What `mukca demo` writes; beside it, in demo.txt, what it says."""

    def make(folder):
        said = folder.with_suffix(".txt").open("w")
        with VirtualTime().running(), said, redirect_stdout(said):
            assert main(["demo", "--out", str(folder)]) == 0

    return shared("demo", make)

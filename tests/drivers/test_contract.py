"""One set of tests over every adapter, with its emulator or stand-in, and on hardware."""

import subprocess
import sys
from pathlib import Path

import pytest
from emulation import emulated, emulated_program, own_bus, own_host
from kortex_stand_in import kortex_arm
from rosbridge import ARM, rosbridge

from mukca.drivers.franka import Franka
from mukca.drivers.kinova import Kinova
from mukca.drivers.kuka import Kuka
from mukca.drivers.mock import Mock
from mukca.drivers.piper import Piper
from mukca.drivers.registry import open_driver
from mukca.drivers.ros import Ros
from mukca.drivers.testing import DriverContract
from mukca.drivers.ur import Ur

ROOT = Path(__file__).parents[2]


class Emulated(DriverContract):
    """The contract over one emulator a class."""

    emulator: str
    options: tuple[str, ...] = ()

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def address(cls, tmp_path_factory):
        folder = tmp_path_factory.mktemp(cls.emulator)
        with emulated(cls.emulator, folder, *cls.options) as emulation:
            yield emulation.address


class OfFranka(Emulated):
    driver = Franka
    emulator = "franka"
    joints = 7
    nobody = own_host()
    wrong = "host:port"


class TestFranka3(OfFranka):
    options = ("--version", "3")


class TestFranka5(OfFranka):
    options = ("--version", "5")


class TestFranka10(OfFranka):
    options = ("--version", "10")


class OfKuka(Emulated):
    driver = Kuka
    emulator = "kuka"
    joints = 7
    nobody = f"{own_host()}?bind={own_host()}"
    wrong = "127.0.0.1?effort=2"


class TestKuka115(OfKuka):
    options = ("--version", "1.15")


class TestKuka25(OfKuka):
    options = ("--version", "2.5")


class TestKuka27(OfKuka):
    options = ("--version", "2.7")


class OfUr(Emulated):
    driver = Ur
    emulator = "ur"
    joints = 6
    nobody = own_host()
    wrong = "127.0.0.1?rate=fast"


class TestUrESeries(OfUr):
    options = ("--version", "5.11")


class TestUrCb3(OfUr):
    options = ("--version", "3.15")


class TestKinovaSerial(Emulated):
    driver = Kinova
    emulator = "kinova"
    joints = 6
    nobody = "serial:///dev/no_such_port"
    wrong = "192.168.1.10"


class TestKinovaCan(Emulated):
    driver = Kinova
    emulator = "kinova"
    options = ("--version", "can")
    joints = 6
    nobody = f"can://{own_bus()}"
    wrong = "can://no_such_interface/can0"


class TestPiper(Emulated):
    driver = Piper
    emulator = "piper"
    joints = 6
    nobody = own_bus()
    wrong = "can0?bitrate=fast"


class TestKinovaKortex(DriverContract):
    driver = Kinova
    joints = 7
    nobody = f"kortex://{own_host()}"
    wrong = "kortex://127.0.0.1?rate=0"

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls):
        with kortex_arm() as arm:
            yield arm.address

    def test_says_that_nobody_answers(self, address):
        super().test_says_that_nobody_answers()


class TestRos(DriverContract):
    driver = Ros
    joints = 3
    model = ARM
    nobody = own_host()
    wrong = "127.0.0.1?effort=0"

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls):
        with rosbridge() as bridge:
            yield bridge.address

    @pytest.fixture
    def opened(self, address):
        with Ros(address, ARM) as driver:
            yield driver


class TestMock(DriverContract):
    driver = Mock
    joints = 2
    wrong = "poses.csv?rate=fast"

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls, tmp_path_factory):
        poses = tmp_path_factory.mktemp("mock") / "poses.csv"
        poses.write_text("0.1,0.2\n0.3,-0.4\n")
        return str(poses)


class TestHardware(DriverContract):
    """On robots: pytest tests/drivers/test_contract.py -k Hardware --hardware franka=172.16.0.2"""

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls, request):
        robots = request.config.getoption("--hardware")
        if not robots:
            pytest.skip("no --hardware NAME=ADDRESS")
        name, _, address = robots[0].partition("=")
        cls.driver = staticmethod(lambda address, names=None: open_driver(name, address, names))
        with open_driver(name, address) as driver:
            cls.joints = len(driver.joint_names)
            cls.model = driver.joint_names
        return address


@pytest.mark.slow
def test_the_contract_runs_on_hardware(tmp_path):
    """The option reaches a robot: here an emulator that passes for one."""
    with emulated_program("ur", tmp_path) as emulation:
        command = [sys.executable, "-m", "pytest", __file__, "-k", "TestHardware", "-q"]
        command += ["-p", "no:xdist", "-p", "no:cacheprovider", "--rootdir", str(ROOT)]
        done = subprocess.run(
            [*command, "--hardware", f"ur={emulation.address}"],
            capture_output=True,
            text=True,
            timeout=120,
            cwd=ROOT,
        )
        emulation.stop()
        assert "11 passed, 2 skipped" in done.stdout, done.stdout
        assert len(emulation.sent()) > 100

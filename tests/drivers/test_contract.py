"""One set of tests over every driver, with its emulator or stand-in, and on hardware."""

import math
import subprocess
import sys
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
from emulation import emulated
from emulator_programs import emulated_program, own_bus, own_host
from kortex_stand_in import TORQUES, kortex_arm
from rosbridge import ARM, arm_state, rosbridge

from mukca.drivers import DriverContract, JointState, open_driver
from mukca.drivers.arms import Motion, SimulatedArm

pytestmark = pytest.mark.waits

ROOT = Path(__file__).parents[2]


class Named(DriverContract):
    """The contract over a driver that is opened by its name."""

    name: str

    def driver(self, address, joint_names=None):
        return open_driver(self.name, address, joint_names)


class Emulated(Named):
    """The contract over one emulator a class."""

    emulator = ""
    """Its name, where it is not the driver's."""
    run = staticmethod(emulated)
    options: tuple[str, ...] = ()

    losses: tuple[str, ...] = ("--fault", "drop:0.05")
    """What makes the emulator lose states that the driver can count; none where it cannot."""

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def emulation(cls, tmp_path_factory):
        name, folder = cls.emulator or cls.name, tmp_path_factory.mktemp(cls.name)
        with cls.run(name, folder, *cls.options) as emulation:
            yield emulation

    def address_of(self, emulation):
        return emulation.address

    @pytest.fixture
    def address(self, emulation):
        return self.address_of(emulation)

    @pytest.fixture
    def sent(self, emulation):
        return lambda: states_of(emulation)

    @pytest.fixture
    def lossy(self, tmp_path):
        if not self.losses:
            yield None
            return
        words = (self.emulator or self.name, tmp_path, *self.options, *self.losses)
        with self.run(*words) as emulation:
            yield self.address_of(emulation), lambda: states_of(emulation)


def states_of(emulation):
    """Return the states that an emulator has sent."""
    return [
        JointState(number, tuple(entry["position"]), tuple(entry["effort"]))
        for number, entry in emulation.sent().items()
    ]


FRANKA = {"name": "franka", "joints": 7, "nobody": own_host(), "wrong": "host:port"}
BIND = f"{own_host()}?bind={own_host()}"
KUKA = {"name": "kuka", "joints": 7, "nobody": BIND, "wrong": "127.0.0.1?effort=2"}
UR = {"name": "ur", "joints": 6, "nobody": own_host(), "wrong": "127.0.0.1?rate=fast"}
TCP = {"losses": ()}  # TCP loses nothing, and reports carry no numbers
XARM = {"name": "xarm", "joints": 6, "nobody": own_host(), "wrong": "127.0.0.1?port=30001", **TCP}
# Answers carry no numbers; with more noise no two states are the same in coarse units.
POLLED = {"losses": (), "options": ("--noise", "1e-2")}
SERVO = {**POLLED, "tolerance": math.pi / 4096 + 1e-9}
DYNAMIXEL = {**SERVO, "name": "dynamixel", "nobody": "/dev/no_such_port?arm=koch"}
ROBOTS = {
    "Franka5": FRANKA,
    "Franka10": {**FRANKA, "options": ("--version", "10")},
    "Kuka115": KUKA,
    "Kuka25": {**KUKA, "options": ("--version", "2.5")},
    "Kuka27": {**KUKA, "options": ("--version", "2.7")},
    "UrESeries": UR,
    "UrCb3": {**UR, "options": ("--version", "3.15")},
    "Feetech": {**SERVO, "name": "feetech", "joints": 5, "nobody": "/dev/no_such_port",
                "wrong": "/dev/ttyACM0?arm=so102"},
    "DynamixelViperX": {**DYNAMIXEL, "joints": 6, "wrong": "/dev/ttyUSB0"},  # which arm?
    "DynamixelKoch": {**DYNAMIXEL, "joints": 5, "wrong": "/dev/ttyUSB0?arm=koch&rate=fast",
                      "options": ("--noise", "1e-2", "--version", "koch")},
    "XArm6": XARM,
    "XArm6Old": {**XARM, "options": ("--version", "xarm6-old")},
    "XArm7": {**XARM, "joints": 7, "options": ("--version", "xarm7")},
    "Damiao": {**POLLED, "name": "damiao", "joints": 7, "tolerance": 2e-4, "nobody": own_bus(),
               "wrong": "can0?signs=2"},
    # Frames carry no numbers: of two turns that are torn one counts.
    "Piper": {"name": "piper", "joints": 6, "losses": (), "options": ("--noise", "1e-3"),
              "tolerance": 1e-5, "nobody": own_bus(), "wrong": "can0?bitrate=fast"},
}  # fmt: skip
globals().update(
    {f"Test{name}": type(f"Test{name}", (Emulated,), of) for name, of in ROBOTS.items()}
)


@pytest.mark.slow
@pytest.mark.skipif(
    find_spec("rtde_receive") is None, reason="ur-rtde has no wheel for this Python"
)
class TestUrRtde(Emulated):
    """In real time: ur-rtde reads in a thread of its own, and holds on to the interpreter."""

    name = "ur-rtde"
    emulator = "ur"
    run = staticmethod(emulated_program)
    joints = 6
    nobody = own_host()
    wrong = "127.0.0.1?rate=fast"
    keeps_all = False  # its receive interface keeps the latest state alone

    def address_of(self, emulation):
        return emulation.host


class TestKinovaSerial(Emulated):
    name = "kinova"
    joints = 6
    losses = ()  # answers carry no numbers
    nobody = "serial:///dev/no_such_port"
    wrong = "192.168.1.10"

    @pytest.fixture
    def sent(self, emulation):
        return lambda: rounds_of(emulation)


def rounds_of(emulation):
    """Return a state for each round of answers from all actuators, one after the other."""
    entries = emulation.entries()
    answers = [
        (bytes.fromhex(request["received"])[3] - 0x10, answer)
        for request, answer in pairwise(entries)
        if "received" in request and "sent" in answer
    ]
    rounds = [answers[start : start + 6] for start in range(len(answers))]
    return [
        JointState(
            0.0,
            tuple(answer["position"][joint] for joint, answer in whole),
            tuple(answer["effort"][joint] for joint, answer in whole),
        )
        for whole in rounds
        if [joint for joint, _ in whole] == list(range(6))
    ]


@pytest.mark.slow
class TestKinovaCan(TestKinovaSerial):
    options = ("--version", "can")
    nobody = f"can://{own_bus()}"
    wrong = "can://no_such_interface/can0"


class TestKinovaKortex(Named):
    name = "kinova"
    joints = 7
    nobody = f"kortex://{own_host()}"
    wrong = "kortex://127.0.0.1?rate=0"

    @pytest.fixture(scope="class")
    @classmethod
    def arm(cls):
        with kortex_arm() as arm:
            yield arm

    @pytest.fixture
    def address(self, arm):
        return arm.address

    @pytest.fixture
    def sent(self, arm):
        def centred(degrees):
            return tuple(math.radians((angle + 180) % 360 - 180) for angle in degrees)

        return lambda: [JointState(0.0, centred(degrees), TORQUES) for degrees in arm.sent]

    def test_says_that_nobody_answers(self, address):
        super().test_says_that_nobody_answers()


class TestRos(Named):
    name = "ros"
    joints = 3
    model = ARM
    nobody = own_host()
    wrong = "127.0.0.1?effort=0"
    tolerance = 1e-9  # the stand-in's steps are small

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls):
        with rosbridge() as bridge:
            yield bridge.address

    @pytest.fixture
    def opened(self, address):
        with open_driver("ros", address, ARM) as driver:
            yield driver

    @pytest.fixture
    def sent(self):
        """Each subscription begins with the first message."""
        return lambda: [JointState(0.0, *arm_state(number)) for number in range(5000)]


class TestMock(Named):
    name = "mock"
    joints = 2
    tolerance = 0.0  # it begins to move very slowly
    wrong = "poses.csv?rate=fast"

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls, tmp_path_factory):
        poses = tmp_path_factory.mktemp("mock") / "poses.csv"
        poses.write_text("0.1,0.2\n0.3,-0.4\n")
        return str(poses)

    @pytest.fixture
    def sent(self):
        """Each connection begins with the first state, and the noise is the same each time."""
        return lambda: self.states(20_000)

    @pytest.fixture
    def lossy(self, address):
        """The same with 50 ms of buffer; the noise is left out, which only states read change."""
        moving = f"{address}?hold=0&move=20&noise=0&buffer=0.05"
        return moving, lambda: self.states(20_000, hold=0.0, move=20.0, noise=0.0)

    def states(self, count, hold=1.0, move=1.0, noise=2e-5):
        arm = SimulatedArm(Motion([[0.1, 0.2], [0.3, -0.4]], hold=hold, move=move), noise=noise)
        return [arm.state(number / arm.rate) for number in range(count)]


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
        command += ["--confcutdir", str(ROOT / "tests")]  # for a clone of any name
        command += ["--hardware", f"ur={emulation.address}"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        emulation.stop()
        assert "11 passed, 5 skipped" in done.stdout, done.stdout
        assert len(emulation.sent()) > 100

"""Universal Robots through ur-rtde: in real time, against an emulator in a program of its own."""

import re
import select
import signal
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from math import inf
from subprocess import PIPE

import pytest
from cases import by_table
from driver_errors import refused
from emulator_programs import emulated_program, own_host
from terminal_session import PATIENCE

from mukca import open_driver

needs_ur_rtde = pytest.mark.skipif(
    find_spec("rtde_receive") is None,
    reason=f"ur-rtde has no wheel for this Python {sys.version_info[:2]}",
)
pytestmark = pytest.mark.slow
REQUESTS = re.compile(
    rb"(\x00\x05V\x00\x02|\x00\x03v|\x00.O.{8}timestamp,actual_q,robot_mode,safety_mode,?|\x00\x03[SP])+",
    re.DOTALL,
)


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    """An emulator that all tests here can use which do not end it."""
    with emulated_program("ur", tmp_path_factory.mktemp("ur")) as emulation:
        yield emulation


@contextmanager
def frozen(controller):
    """Within it the controller does nothing."""
    controller.running.process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        controller.running.process.send_signal(signal.SIGCONT)


@needs_ur_rtde
@pytest.mark.parametrize(("version", "period"), [("3.15", 0.008), ("5.11", 0.002)])
def test_the_controller_s_rate_counts_what_was_missed(version, period, tmp_path):
    with emulated_program("ur", tmp_path, "--version", version) as emulation:
        with open_driver(f"ur-rtde:{emulation.host}") as driver:
            states = [driver.read(PATIENCE)]
            missed = -driver.missed
            states += [driver.read(PATIENCE) for _ in range(100)]
            missed += driver.missed
            assert driver.status == "running, normal"
        emulation.stop()
        sent, received = emulation.sent(), [message for _, message in emulation.received()]
    for state in states:
        assert state.position == tuple(sent[round(state.stamp / period)]["position"])
    assert missed == round((states[-1].stamp - states[0].stamp) / period) + 1 - len(states)
    assert all(REQUESTS.fullmatch(message) for message in received), "more than outputs was sent"
    assert received


@needs_ur_rtde
def test_the_end_of_the_connection_is_told(tmp_path):
    with (
        emulated_program("ur", tmp_path) as emulation,
        open_driver("ur-rtde", emulation.host) as driver,
        refused("UNREACHABLE"),
    ):
        emulation.stop()
        while True:
            driver.read(PATIENCE)


@needs_ur_rtde
@pytest.mark.waits
def test_a_silence_is_told(controller):
    with open_driver("ur-rtde", controller.host) as driver, frozen(controller), refused("SILENT"):
        while True:
            driver.read(0.5)


@needs_ur_rtde
@pytest.mark.waits
def test_a_controller_that_freezes_freezes_nothing_else(controller):
    """Not while it streams, and not where it takes the connection and is mute."""
    command = [sys.executable, "-m", "mukca", "stream", "--json", "--driver"]
    words = [*command, f"ur-rtde:{controller.host}"]
    with subprocess.Popen(words, stdout=PIPE, stderr=PIPE, text=True) as program:
        watchdog = threading.Timer(PATIENCE, program.kill)
        watchdog.start()
        try:
            assert program.stdout.readline()  # the package streams
            with frozen(controller):
                while "took the connection but did not answer" not in program.stderr.readline():
                    assert program.poll() is None
                program.send_signal(signal.SIGINT)
                assert program.wait(PATIENCE) == 130
        finally:
            watchdog.cancel()
            program.kill()


def hang_after(packages, listener, controller, hung, left):
    """Pass one connection on to a controller, and of the next one so many packages from it."""
    for most in (inf, packages):
        client, server = listener.accept()[0], socket.create_connection(controller)
        with client, server, suppress(OSError):  # who leaves may reset its connection
            while ready := select.select([client] + [server] * (most > 0), [], [])[0]:
                if client in ready:
                    if not (request := client.recv(4096)):
                        break
                    server.sendall(request)
                elif head := server.recv(3, socket.MSG_WAITALL):
                    size = (head[0] << 8 | head[1]) - len(head)
                    client.sendall(head + server.recv(size, socket.MSG_WAITALL))
                    most -= 1
                if most == 0:
                    hung.set()
    left.set()


@needs_ur_rtde
@pytest.mark.waits
@by_table("packages", "after", "stop", "status")
def test_a_stop_is_obeyed_wherever_the_controller_hangs(packages, after, stop, status, controller):
    """The package's own connection hangs after the driver's; no process is left, either."""
    hung, left, host = threading.Event(), threading.Event(), own_host()
    with socket.create_server((host, 30004)) as listener:
        relayed = packages, listener, (controller.host, 30004), hung, left
        threading.Thread(target=hang_after, args=relayed, daemon=True).start()
        words = [sys.executable, "-m", "mukca", "stream", "--json", "--driver", f"ur-rtde:{host}"]
        with subprocess.Popen(words, stdout=PIPE, stderr=PIPE) as program:
            try:
                assert hung.wait(PATIENCE), f"the package was never {after}"
                program.send_signal(getattr(signal, stop))
                assert program.wait(PATIENCE) == status
            finally:
                program.kill()
        assert left.wait(PATIENCE), "the package's process is still connected"


TORN = """
class RTDEReceiveInterface:
    number, asked = 1, 0
    def __init__(self, *settings): print("what it prints is no state")
    def getTimestamp(self): return 0.002 * self.number
    def getActualQ(self):
        self.asked += 1
        self.number += self.asked % 3 > 0  # in two cases of three, after the stamp was asked
        return [0.001 * self.number] * 6
    def getRobotMode(self): return 7
    def getSafetyMode(self): return 1
    def isConnected(self): return True
"""


def test_stamp_and_angles_are_of_one_state(monkeypatch, tmp_path, controller):
    """The interface may take in a state between two questions."""
    (tmp_path / "rtde_receive.py").write_text(TORN)
    monkeypatch.syspath_prepend(tmp_path)
    with open_driver("ur-rtde", controller.host) as driver:
        for state in [driver.read(PATIENCE) for _ in range(20)]:
            assert state.position == pytest.approx([state.stamp / 2] * 6)


def test_what_the_package_cannot_connect_to_is_told(monkeypatch, tmp_path, controller):
    (tmp_path / "rtde_receive.py").write_text("raise RuntimeError('no such output')")
    monkeypatch.syspath_prepend(tmp_path)
    with refused("BUSY", match=r"not ur-rtde's: .* RuntimeError: no such output"):
        open_driver("ur-rtde", controller.host)


def test_a_package_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "rtde_receive", None)
    with refused("MISSING_PACKAGE", match=r"pip install ur-rtde.*--driver ur"):
        open_driver("ur-rtde", "127.0.0.1")


@needs_ur_rtde
def test_another_port_is_refused():
    with refused("BAD_ADDRESS", match="port 30004 alone"):
        open_driver("ur-rtde", "127.0.0.1:40004")

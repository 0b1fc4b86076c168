"""Break every controller in every way, and count what the drivers and the recorder make of it.

::

    python benchmarks/faults.py [NAME ...] [--kills 1000] [--messages 1000000] [--disks 50]
                                [--clocks 10]

Each controller is an emulator, a program of its own, that is hung (stopped by a signal), silent, or
stalled for some seconds, started again, or garbles and repeats messages; or this computer's clock
is set forward and back by 5 s and by an hour. The driver reads all the while, and connects again by
itself. A line of the table has the states read, those that were never sent (of polled arms: one
joint's angle), those off by half a second by the emulator's journal where the stamps are the
host's, the seconds from the fault's end to the next state (of the clock: the longest pause), and
what was said last. ``--kills`` kills recording sessions, also with their stream kept;
``--messages`` gives spoilt messages to all decoders; ``--disks`` records on disks that are full
after some bytes; ``--clocks`` records while the clock is set.
"""

import argparse
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from itertools import pairwise
from pathlib import Path

import can
import can.bus
import numpy as np

from mukca import MukcaError, read_placements
from mukca.drivers import DriverError, JointState, Reconnecting, open_driver
from mukca.recorder import read_stream_log
from mukca.tools.cli import main as mukca

HERE = Path(__file__).parent
HOST = "127.77.0.1"
BUS = "udp_multicast/239.74.163.2?port=43197&hop_limit=0"
START, LENGTH, END = 1.5, 3.0, 9.0  # s
GARBLED = ("drop:0.02", "duplicate:0.02", "truncate:0.02", "garble:0.02")
CONTROLLERS = {
    "franka, FCI 5": ("franka", HOST, "--version", "5"),
    "franka, FCI 10": ("franka", HOST, "--version", "10"),
    "kuka, FRI 2.7": ("kuka", "127.77.0.2?client=127.77.0.3", "--version", "2.7"),
    "ur": ("ur", HOST),
    "ur-rtde": ("ur", HOST),
    "xarm": ("xarm", HOST),
    "piper": ("piper", BUS),
    "damiao": ("damiao", BUS),
    "kinova, CAN": ("kinova", BUS, "--version", "can"),
    "kinova, serial": ("kinova", ""),
    "feetech": ("feetech", ""),
    "dynamixel": ("dynamixel", ""),
    "ros": ("ros", "127.77.0.4:9090"),
}
ROUNDING = {"piper": 1e-5, "damiao": 2e-4, "feetech": 8e-4, "dynamixel": 8e-4}  # rad
POLLED = ("damiao", "kinova", "feetech", "dynamixel")


@dataclass
class Run:
    """One driver that reads one controller through one fault."""

    states: list[tuple[float, JointState]] = field(default_factory=list)
    """With the times at which they were read [s]."""
    said: str = ""

    def read(self, driver: Reconnecting, until: float) -> None:
        """Read until a moment [s]."""
        while time.monotonic() < until:
            try:
                state = driver.read(0.2)
                self.states.append((time.monotonic(), state))
            except DriverError as error:
                self.said = str(error)

    def back_after(self, moment: float) -> float:
        """Return the time to the first state after a moment [s]."""
        return (
            min((at for at, _ in self.states if at > moment), default=float("inf"))
            - moment
        )

    def longest_pause(self) -> float:
        """Return the longest time between two states [s]."""
        return max(
            (b - a for (a, _), (b, _) in pairwise(self.states)), default=float("inf")
        )


class Controller:
    """An emulator's program, which may be stopped, or started again."""

    def __init__(self, name: str, folder: Path, faults: tuple[str, ...]) -> None:
        kind, address, *options = CONTROLLERS[name]
        self.kind, self._folder, self._starts = kind, folder, 0
        self._words = [
            "-m",
            "mukca",
            "emulate",
            kind,
            "--json",
            "--hold",
            "0.2",
            *options,
        ]
        if kind == "ros":
            self._words = [str(HERE.parent / "tests/rosbridge.py")]
        self._words += ["--address", address]
        self._words += [word for fault in faults for word in ("--fault", fault)]
        self.start()

    def start(self) -> None:
        """Start the program, and wait for its address."""
        self._starts += 1
        journal = str(self._folder / f"journal{self._starts}.jsonl")
        command = [sys.executable, *self._words, "--journal", journal]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout
        self.driver = json.loads(self.process.stdout.readline())["driver"]

    def restart(self) -> None:
        """End the program, and start it again after a while."""
        self.process.kill()
        self.process.wait()
        time.sleep(LENGTH)
        self.start()

    def sent(self) -> list[tuple[float, list[float]]]:
        """Return when each state was sent [s], and its positions."""
        lines = [
            json.loads(line)
            for file in sorted(self._folder.glob("journal*.jsonl"))
            for line in file.read_text().splitlines(keepends=True)
            if line.endswith("\n") and line.startswith('{"sent"')
        ]
        return [(line["at"], line["position"]) for line in lines]


def hang(controller: Controller) -> None:
    controller.process.send_signal(signal.SIGSTOP)
    time.sleep(LENGTH)
    controller.process.send_signal(signal.SIGCONT)


def set_clock(_: object) -> None:
    """Set what tells the wall's time here: Python, and the stamps of CAN frames."""
    told, receive, ahead = time.time, can.BusABC.recv, 0.0

    def receive_later(
        bus: can.BusABC, timeout: float | None = None
    ) -> can.Message | None:
        if frame := receive(bus, timeout):
            frame.timestamp += ahead
        return frame

    time.time = can.bus.time = lambda: told() + ahead
    can.BusABC.recv = receive_later
    for ahead in (5.0, 0.0, 3600.0, 0.0):  # noqa: B007 - used above
        time.sleep(LENGTH / 4)
    time.time = can.bus.time = told
    can.BusABC.recv = receive


FAULTS: dict[str, tuple[tuple[str, ...], Callable[[Controller], None] | None]] = {
    "hung": ((), hang),
    "silent": ((f"silent@{START}+{LENGTH}",), None),
    "stalled": ((f"stall@{START}+{LENGTH}",), None),
    "restarted": ((), Controller.restart),
    "garbled": (GARBLED, None),
    "clock set": ((), set_clock),
}


def strike(name: str, fault: str) -> str:
    """Return a line of the table."""
    options, act = FAULTS[fault]
    with tempfile.TemporaryDirectory() as folder:
        controller = Controller(name, Path(folder), options)
        address = controller.driver
        if name == "ur-rtde":
            address = f"ur-rtde:{HOST}"
        run = Run()
        try:
            begun = time.monotonic()
            with Reconnecting(lambda: open_driver(address)) as driver:
                if act:
                    threading.Timer(START, act, (controller,)).start()
                run.read(driver, begun + END)
        except MukcaError as error:
            run.said = f"GAVE UP: {error}"
        finally:
            controller.process.kill()
            controller.process.wait()
        by_host = controller.kind in POLLED or (controller.kind, fault) == (
            "piper",
            "clock set",
        )
        wrong, old = compare(run.states, controller, by_host)
        back = (
            0.0 if fault == "garbled" else run.back_after(begun + START + LENGTH + 0.05)
        )
        back = run.longest_pause() if fault == "clock set" else back
        cells = [name, fault, len(run.states), wrong, old, f"{back:.1f}", run.said]
        return f"| {' | '.join(map(str, cells))} |"


def compare(
    states: list[tuple[float, JointState]], controller: Controller, by_host: bool
) -> tuple[int, int | str]:
    """Count the states that were never sent, and those that were older than their stamps."""
    at = np.array([moment for moment, _ in controller.sent()])
    truth = np.array([position for _, position in controller.sent()])
    step = ROUNDING.get(controller.kind, 1e-6)
    wrong = old = 0
    for _, state in states:
        told = np.abs(truth - state.position) <= step
        off = (
            np.where(told, np.abs(at - state.stamp)[:, None], np.inf).min(axis=0).max()
        )
        wrong += np.isinf(off)
        old += by_host and 0.5 < off < np.inf
    return wrong, old if by_host else "-"


def recording(folder: Path) -> list[str]:
    """Return the words that record a simulated Panda at twelve configurations."""
    hand, keys, source = folder / "hand.csv", folder / "keys.txt", random.Random(3)
    poses = [[source.uniform(-0.6, 0.6) for _ in range(3)] for _ in range(60)]
    hand.write_text("\n".join(f"{a},{b},{c},-1.5,0.1,1.8,0.2" for a, b, c in poses))
    keys.write_text("a*12 q")
    driver = f"mock:{hand}?rate=200&hold=0.7&move=0.3&speed=4"
    words = ["record", "--robot", "panda", "--driver", driver, "--keys", str(keys)]
    return [*words, "--keep-stream"]


def fill_disks(count: int) -> str:
    """Record on disks that are full after some bytes; return what came of it."""
    source = random.Random(0)
    saved = states = 0
    with tempfile.TemporaryDirectory() as folder:
        words = recording(Path(folder))
        for number in range(count):
            out = Path(folder) / f"front{number}"
            limit = source.randrange(1500, 60_000)
            done = subprocess.run(
                [sys.executable, "-m", "mukca", *words, "--out", str(out)],
                preexec_fn=partial(
                    resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit)
                ),
                capture_output=True,
                text=True,
            )
            if "Traceback" in done.stderr or list(out.glob(".*.tmp")):
                raise SystemExit(f"{limit} bytes: {done.stderr}")
            saved += (
                sum(len(p.samples) for p in read_placements(out))
                if (out / "samples.csv").exists()
                else 0
            )
            for log in out.glob("*.stream"):
                kept = read_stream_log(log)
                states += len(kept.stamps)
                if kept.remarks:
                    raise SystemExit(f"{limit} bytes: {kept.remarks}")
    return f"{count} full disks: {saved} samples and {states} states kept, all whole"


def set_clocks(count: int) -> str:
    """Record while the clock is set forward and back; return what came of it."""
    saved = 0
    with tempfile.TemporaryDirectory() as folder:
        words = recording(Path(folder))
        for number in range(count):
            threading.Timer(1.0, set_clock, (None,)).start()
            out = Path(folder) / f"front{number}"
            with redirect_stdout(StringIO()):
                status = mukca([*words, "--out", str(out)])
            log = read_stream_log(next(out.glob("*.stream")))
            if status or log.remarks or (np.diff(log.stamps) <= 0).any():
                raise SystemExit(f"clock set: status {status}, {log.remarks}")
            saved += sum(len(placement.samples) for placement in read_placements(out))
    return f"{count} sessions while the clock was set: {saved} of {12 * count} samples kept"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="begin of a controller's name"
    )
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--disks", type=int, default=0)
    parser.add_argument("--clocks", type=int, default=0)
    arguments = parser.parse_args()
    print(
        "| controller | fault | states | never sent | old | back after [s] | said last |"
    )
    print("|---|---|---|---|---|---|---|")
    for name in CONTROLLERS:
        if not arguments.names or name.startswith(tuple(arguments.names)):
            for fault in FAULTS:
                # Its name changes.
                line = CONTROLLERS[name][1] == "" and fault == "restarted"
                if not line:
                    print(strike(name, fault), flush=True)
    if arguments.disks:
        print(fill_disks(arguments.disks))
    if arguments.clocks:
        print(set_clocks(arguments.clocks))
    if arguments.kills:
        program = HERE.parent / "tests/recorder/killed_sessions.py"
        environment = {
            **os.environ,
            "PYTHONPATH": f"{HERE.parent / 'tests'}:{os.environ.get('PYTHONPATH', '')}",
        }
        with tempfile.TemporaryDirectory() as folder:
            words = [
                sys.executable,
                str(program),
                f"{folder}/front",
                str(arguments.kills),
            ]
            subprocess.run(words, env=environment, check=True)


if __name__ == "__main__":
    main()

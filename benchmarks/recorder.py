"""How much the recorder costs, and whether it misses anything: a soak in a real pseudo-terminal.

    python benchmarks/recorder.py                 a minute
    python benchmarks/recorder.py --minutes 10    the long one

``mukca record`` runs on a simulated Panda that streams 1000 states a second and forgets what is not
read within 0.1 s, as a socket's buffer does. A key is pressed every second, whatever the arm does,
and the socket changed half-way, so that the live fit runs after every capture; the page is open and
followed. The baseline, in the same run, is a bare loop that reads the same arm and does nothing
else; the simulated arm itself runs in the same process in both.
"""

import argparse
import contextlib
import fcntl
import os
import re
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import psutil

from mukca.recorder import write_holes
from mukca.solver.identification.robot import load_robot
from mukca.tools.simulation import Base, perturb
from mukca.tools.simulation import record as record_arm

RATE = 1000
BARE = """
import sys, time
from mukca.drivers.registry import open_driver
driver = open_driver("mock", sys.argv[1])
begun, used = time.monotonic(), time.process_time()
while time.monotonic() - begun < float(sys.argv[2]):
    driver.read(1.0)
print((time.process_time() - used) / (time.monotonic() - begun), driver.missed)
"""


class Terminal:
    """A pseudo-terminal whose output is read and counted."""

    def __init__(self, columns: int, rows: int) -> None:
        self.master, self.slave = os.openpty()
        size = struct.pack("HHHH", rows, columns, 0, 0)
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, size)
        self.frames = self.size = 0
        self.tail = b""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while True:
            data = os.read(self.master, 65536)
            self.size += len(data)
            # This line changes in every drawing.
            self.frames += data.count(b"last state")
            self.tail = (self.tail + data)[-200_000:]

    def last(self, pattern: str) -> str:
        """The last match on the screen."""
        found = re.findall(pattern.encode(), self.tail)
        return found[-1].decode() if found else "?"


def write_hand(folder: Path, each: int) -> None:
    """Write where a hand leads a Panda: so many poses in each of two sockets."""
    arm = perturb(load_robot("panda"), np.random.default_rng(0), 2e-3, 5e-3)
    base = Base("front", np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]))
    write_holes(
        record_arm(arm, base, np.random.default_rng(1), samples=each, noise=1e-4),
        folder,
    )


class Browser:
    """Follows the page, as a tablet does: four states a second."""

    def __init__(self, url: str) -> None:
        self.states = 0
        self._url = url
        threading.Thread(target=self._follow, daemon=True).start()

    def _follow(self) -> None:
        with contextlib.suppress(URLError):
            while True:
                with urlopen(self._url + "state") as answer:
                    self.states += bool(answer.read())
                time.sleep(0.25)


def soak(hand: Path, out: Path, seconds: float, columns: int, rows: int) -> float:
    """Record for some time; print what it cost and return its share of a core."""
    terminal = Terminal(columns, rows)
    driver = f"mock:{hand}?rate={RATE}&buffer=0.1&hold=1.5&move=0.5"
    words = [
        sys.executable,
        "-m",
        "mukca",
        "record",
        "--robot",
        "panda",
        "--driver",
        driver,
        "--distance",
        "0.05",
    ]
    recorder = subprocess.Popen(
        [*words, "--out", str(out), "--target", "1000", "--page", "--goal-mm", "0.001"],
        stdin=terminal.slave,
        stdout=terminal.slave,
        stderr=terminal.slave,
        env={**os.environ, "TERM": "xterm-256color"},
        start_new_session=True,
    )
    process = psutil.Process(recorder.pid)
    while not terminal.frames:
        time.sleep(0.05)
    browser = Browser(terminal.last(r"http://[!-~]+/"))
    time.sleep(5.0)  # what it allocates once
    beside = process.children()
    alone = [cpu(child) for child in beside]
    begun, used, frames, size = (
        time.monotonic(),
        cpu(process),
        terminal.frames,
        terminal.size,
    )
    memory = [process.memory_info().rss]
    switched = False
    while time.monotonic() - begun < seconds:
        time.sleep(1.1)  # at least once in each rest, and often where it is refused
        os.write(terminal.master, b" ")
        if not switched and time.monotonic() - begun > seconds / 2:
            switched = True
            os.write(terminal.master, b"s")
        memory.append(process.memory_info().rss)
    elapsed = time.monotonic() - begun
    share = (cpu(process) - used) / elapsed
    shares = [
        (cpu(child) - a) / elapsed for child, a in zip(beside, alone, strict=True)
    ]
    frames, size = terminal.frames - frames, terminal.size - size
    missed, captured = (
        terminal.last(r"missed (\d+)"),
        terminal.last(r"captured sample (\d+)"),
    )
    os.write(terminal.master, b"q")
    status = recorder.wait(30)
    print(f"  {columns} x {rows}, {elapsed:.0f} s, exit status {status}")
    print(f"  states missed        {missed} of {elapsed * RATE:.0f}")
    print(f"  captures             {captured}")
    print(
        f"  frames               {frames / elapsed:.1f} /s, {size / elapsed / 1e3:.1f} kB/s"
    )
    print(f"  share of one core    {share:.1%}")
    print(
        f"  beside it            {' and '.join(f'{s:.1%}' for s in shares)} (page and fit)"
    )
    print(f"  states to a browser  {browser.states / elapsed:.1f} /s")
    print(
        f"  predicted error      {terminal.last(r'predicted ([0-9.]+)')} mm at the end"
    )
    print(f"  memory               {memory[0] / 1e6:.1f} MB, after a tenth of the time "
          f"{memory[len(memory) // 10] / 1e6:.1f}, at the end {memory[-1] / 1e6:.1f}")  # fmt: skip
    return share


def cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return times.user + times.system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    minutes = parser.parse_args().minutes
    with tempfile.TemporaryDirectory() as folder:
        hand = Path(folder) / "hand"
        write_hand(hand, max(20, round(15 * minutes)))
        address = f"{hand}?rate={RATE}&buffer=0.1&hold=1.5&move=0.5"
        words = [sys.executable, "-c", BARE, address, "10"]
        bare, missed = subprocess.check_output(words, text=True).split()
        print(
            f"a bare loop over the same arm: {float(bare):.1%} of one core, {missed} missed"
        )
        print("mukca record")
        share = soak(hand, Path(folder) / "front", 60 * minutes, 80, 24)
        print(f"  ratio to the bare loop {share / float(bare):.1f}")
        print("mukca record on a large screen")
        soak(hand, Path(folder) / "large", min(20.0, 60 * minutes), 200, 50)


if __name__ == "__main__":
    main()

"""How much the recorder costs, and whether it misses anything: a soak in a real pseudo-terminal.

    python benchmarks/recorder.py                 a minute
    python benchmarks/recorder.py --minutes 10    the long one

``mukca record`` runs on a simulated 7-joint arm that streams 1000 states a second and forgets what
is not read within 0.1 s, as a socket's buffer does. A key is pressed every other second. The
baseline, in the same run, is a bare loop that reads the same arm and does nothing else; the
simulated arm itself runs in the same process in both.
"""

import argparse
import fcntl
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
from pathlib import Path

import psutil

RATE = 1000
HOME = (0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7)
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
            self.frames += data.count(b"last state")  # this line changes in every drawing
            self.tail = (self.tail + data)[-200_000:]

    def last(self, pattern: str) -> str:
        """The last match on the screen."""
        found = re.findall(pattern.encode(), self.tail)
        return found[-1].decode() if found else "?"


def write_hand(file: Path) -> None:
    generator = random.Random(0)
    rows = [[q + generator.uniform(-0.6, 0.6) for q in HOME] for _ in range(1000)]
    file.write_text("\n".join(",".join(map(repr, row)) for row in rows))


def soak(hand: Path, out: Path, seconds: float, columns: int, rows: int) -> float:
    """Record for some time; print what it cost and return its share of a core."""
    terminal = Terminal(columns, rows)
    driver = f"mock:{hand}?rate={RATE}&buffer=0.1&hold=1.5&move=0.5"
    words = [sys.executable, "-m", "mukca", "record", "--robot", "panda", "--driver", driver]
    recorder = subprocess.Popen(
        [*words, "--out", str(out), "--target", "1000"],
        stdin=terminal.slave,
        stdout=terminal.slave,
        stderr=terminal.slave,
        env={**os.environ, "TERM": "xterm-256color"},
        start_new_session=True,
    )
    process = psutil.Process(recorder.pid)
    while not terminal.frames:
        time.sleep(0.05)
    time.sleep(5.0)  # what it allocates once
    begun, used, frames, size = time.monotonic(), cpu(process), terminal.frames, terminal.size
    memory = [process.memory_info().rss]
    while time.monotonic() - begun < seconds:
        time.sleep(2.0)
        os.write(terminal.master, b" ")
        memory.append(process.memory_info().rss)
    elapsed = time.monotonic() - begun
    share = (cpu(process) - used) / elapsed
    frames, size = terminal.frames - frames, terminal.size - size
    missed, captured = terminal.last(r"missed (\d+)"), terminal.last(r"captured sample (\d+)")
    os.write(terminal.master, b"q")
    status = recorder.wait(30)
    print(f"  {columns} x {rows}, {elapsed:.0f} s, exit status {status}")
    print(f"  states missed        {missed} of {elapsed * RATE:.0f}")
    print(f"  captures             {captured}")
    print(f"  frames               {frames / elapsed:.1f} /s, {size / elapsed / 1e3:.1f} kB/s")
    print(f"  share of one core    {share:.1%}")
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
        hand = Path(folder) / "hand.csv"
        write_hand(hand)
        address = f"{hand}?rate={RATE}&buffer=0.1&hold=1.5&move=0.5"
        words = [sys.executable, "-c", BARE, address, "10"]
        bare, missed = subprocess.check_output(words, text=True).split()
        print(f"a bare loop over the same arm: {float(bare):.1%} of one core, {missed} missed")
        print("mukca record")
        share = soak(hand, Path(folder) / "front", 60 * minutes, 80, 24)
        print(f"  ratio to the bare loop {share / float(bare):.1f}")
        print("mukca record on a large screen")
        soak(hand, Path(folder) / "large", min(20.0, 60 * minutes), 200, 50)


if __name__ == "__main__":
    main()

"""Kills the recorder again and again, at random moments, while it captures.

A program of its own, since it forks: ``python killed_sessions.py FOLDER ROUNDS``. Every round
continues the same placement in a new pseudo-terminal and ends by SIGKILL. What the screen had
counted by then must be in the file, and stay there. The recorder lives in virtual time, and so
captures as fast as the computer can.
"""

import os
import pty
import random
import re
import select
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

from rich.console import Console
from virtual_time import VirtualTime

from mukca.drivers.arms import Mock, Motion, SimulatedArm
from mukca.recorder import read_samples
from mukca.recorder.session import Recording, Session
from mukca.recorder.session.recording_file import Metadata
from mukca.recorder.stream import JointLimits, Stream, StreamMonitor
from mukca.recorder.terminal import Recorder, Screen, Script

JOINTS = tuple(JointLimits(f"joint{i}", -3, 3) for i in range(7))


def record(folder: Path, seed: int) -> None:
    """Capture one configuration after the other, as fast as it goes."""
    generator = random.Random(seed)
    places = [[generator.uniform(-2, 2) for _ in JOINTS] for _ in range(500)]
    arm = SimulatedArm(Motion(places, hold=0.65, move=0.35), rate=50, speed=20)
    metadata = Metadata("arm", tuple(j.name for j in JOINTS), ("rad",) * 7, 0.05)
    reader, writer = os.pipe()
    os.write(writer, b"a*500\n")
    with Recording(folder, metadata) as recording, VirtualTime().running():
        content = recording.content
        session = Session(JOINTS, samples=content.samples, withdrawn=content.withdrawn)
        stream = Stream(Mock(arm=arm))
        watch = StreamMonitor(JOINTS, live=False)
        Recorder(session, stream, watch, recording, Screen(Console()), script=Script(reader)).run()


def counted(output: bytes) -> int:
    """The last number of captures that the screen showed."""
    found = re.findall(rb" 0: +(\d+)/30", output)
    return int(found[-1]) if found else 0


def killed(folder: Path, seed: int, generator: random.Random) -> int:
    """Run a session, kill it at some moment after its first capture; return what it counted."""
    before = counted_in(folder)
    process, terminal = pty.fork()
    if process == 0:
        os.environ["TERM"] = "xterm-256color"
        record(folder, seed)
        os._exit(1)
    output = b""
    end, patience = None, time.monotonic() + 30
    while time.monotonic() < (end or patience):
        if select.select([terminal], [], [], 0.005)[0]:
            try:
                output += os.read(terminal, 65536)
            except OSError:
                break
        if end is None and counted(output) > before:
            end = time.monotonic() + generator.uniform(0.0, 0.05)
    os.kill(process, signal.SIGKILL)
    status = os.waitpid(process, 0)[1]
    output += drained(terminal)
    assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL, output[-2000:]
    os.close(terminal)
    return counted(output)


def drained(terminal: int) -> bytes:
    """What the killed program had still written; then the terminal ends."""
    output = b""
    with suppress(OSError):
        while data := os.read(terminal, 65536):
            output += data
    return output


def counted_in(folder: Path) -> int:
    file = folder / "samples.csv"
    return len(read_samples(file).samples) if file.exists() else 0


def main() -> None:
    folder, rounds = Path(sys.argv[1]), int(sys.argv[2])
    generator = random.Random(5)
    for number in range(rounds):
        before = counted_in(folder)
        shown = killed(folder, number, generator)
        saved = counted_in(folder)
        # one more may be on the disk than the screen had time to show
        assert before < shown <= saved, f"round {number}: {before}, {shown} shown, {saved} saved"
    print(f"{rounds} kills, {counted_in(folder)} samples, all there")


if __name__ == "__main__":
    main()

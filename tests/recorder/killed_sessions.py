"""Kills ``mukca record`` again and again, at random moments, while it captures.

A program of its own, since it forks: ``python killed_sessions.py FOLDER ROUNDS``. Every round
continues the same placement in a new pseudo-terminal and ends by SIGKILL; every other one keeps
its stream. What the screen had counted by then must be in the file, and stay there, and the streams
be read but for a torn end. The recorder lives in virtual time, and so captures as fast as it can.
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

from record_commands import configurations
from terminal_session import PATIENCE
from virtual_time import VirtualTime

from mukca.recorder import read_stream_log
from mukca.tools.cli import main


def record(folder, seed, script="a*500"):
    """Capture one configuration after the other, as fast as it goes."""
    hand, keys = folder.parent / "hand.csv", folder.parent / "keys.txt"
    hand.write_text("\n".join(",".join(map(repr, q)) for q in configurations(500, seed)))
    keys.write_text(script)
    rate = 1000 if seed % 2 else 50  # a block of the stream has 1000 states
    driver = f"mock:{hand}?rate={rate}&speed=20&hold=0.65&move=0.35"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(folder)]
    words += ["--keep-stream"] * (seed % 2)
    with VirtualTime().running():
        main([*words, "--keys", str(keys), "--target", "10000"])


def counted(output):
    """The last number of captures that the screen showed."""
    found = re.findall(rb" 0: *(\d+)/10000", output)
    return int(found[-1]) if found else 0


def killed(folder, seed, generator):
    """Run a session, kill it at some moment after its first capture; return what it counted."""
    before = counted_in(folder)
    process, terminal = pty.fork()
    if process == 0:
        os.environ["TERM"] = "xterm-256color"
        record(folder, seed)
        os._exit(1)
    output = b""
    end, patience = None, time.monotonic() + PATIENCE
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
    with suppress(OSError):  # what the killed program had still written; then the terminal ends
        while data := os.read(terminal, 65536):
            output += data
    assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL, output[-2000:]
    os.close(terminal)
    return counted(output)


def counted_in(folder):
    """The number of whole captures in the file."""
    file = folder / "samples.csv"
    whole = file.read_bytes().rpartition(b"\n")[0] if file.exists() else b""
    return whole.count(b"\ncapture")


if __name__ == "__main__":
    folder, rounds = Path(sys.argv[1]), int(sys.argv[2])
    generator = random.Random(5)
    record(folder.with_name("first"), 1, "a q")  # what it imports, every round has then
    for number in range(rounds):
        before = counted_in(folder)
        shown = killed(folder, number, generator)
        saved = counted_in(folder)
        # one more may be on the disk than the screen had time to show
        assert before < shown <= saved, f"round {number}: {before}, {shown} shown, {saved} saved"
        for log in folder.glob("*.stream"):
            assert len(read_stream_log(log).stamps) % 1000 == 0  # whole blocks alone
    assert main(["info", str(folder)]) == 0
    print(f"{rounds} kills, {counted_in(folder)} samples, all there")

"""Emulated controllers as programs, on addresses that no other test uses."""

import itertools
import json
import select
import socket
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
import pytest

START_SECONDS = 200
_numbers = itertools.count()


def _claim_range():
    """Return a range of addresses, and the socket that keeps other runs of tests out of it."""
    for k in range(100):
        claim = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            claim.bind(("127.0.0.1", 43000 + k))
            return k, claim
        except OSError:
            claim.close()
    raise OSError("too many runs of tests at once on this computer")


_range, _claim = _claim_range()


@dataclass
class Emulation:
    """A running emulator."""

    name: str
    address: str
    """What the driver takes."""
    running: Any
    """What it runs in, which can ``release`` and ``stop`` it."""
    journal: Path

    @property
    def host(self):
        """The controller's IP address."""
        return self.address.partition(":")[0]

    @property
    def emulator(self):
        """The emulator itself, where it runs in this process."""
        return self.running.emulator

    def entries(self):
        """Return the journal's whole lines."""
        lines = self.journal.read_text(encoding="utf-8").splitlines(keepends=True)
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def received(self):
        """Return the messages that came in: channel and bytes."""
        return [
            (entry["channel"], bytes.fromhex(entry["received"]))
            for entry in self.entries()
            if "received" in entry
        ]

    def sent(self):
        """Return the states that went out, by number."""
        return {entry["sent"]: entry for entry in self.entries() if "sent" in entry}

    def release(self):
        """Let an arm move that was told to wait."""
        self.running.release()

    def stop(self):
        """End it, with its journal whole."""
        self.running.stop()


@contextmanager
def emulated_program(name, folder, *options, command=(sys.executable, "-m", "mukca")):
    """Run ``mukca emulate`` as a program of its own, in real time."""
    words, journal = emulator_words(name, folder, options)
    process = subprocess.Popen(
        [*command, "emulate", *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    running = _Program(process)
    try:
        ready, _, _ = select.select([process.stdout], [], [], START_SECONDS)
        line = process.stdout.readline() if ready else ""
        assert line, f"the emulator did not start: {command}"
        told = json.loads(line)["driver"]
        yield Emulation(name, told.partition(":")[2], running, journal)
    finally:
        running.stop()
        process.communicate()


@dataclass
class _Program:
    """An emulator in a process of its own."""

    process: subprocess.Popen[str]

    def release(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def stop(self):
        self.process.terminate()
        self.process.wait(START_SECONDS)


def emulator_words(name, folder, options):
    """Return an emulator's arguments, at an address that nobody else uses, and its journal."""
    journal = folder / f"journal{next(_numbers)}.jsonl"
    address = own_address(name, options)
    if address.startswith("udp_multicast"):
        need_multicast()
    return [name, "--json", "--journal", str(journal), "--address", address, *options], journal


def own_address(name, options=()):
    """Return an address for an emulator that nobody else uses."""
    if name in ("piper", "damiao") or (name == "kinova" and "can" in options):
        return own_bus()
    if name in ("kinova", "feetech", "dynamixel"):  # a terminal of its own
        return ""
    if name == "kuka":
        return f"{own_host()}?client={own_host()}"
    return own_host()


def own_host():
    """Return a loopback address that nobody else uses."""
    number = next(_numbers)
    return f"127.{20 + _range}.{number // 200}.{1 + number % 200}"


def own_bus():
    """Return a CAN bus that nobody else uses: one by its port, since Linux mixes the groups."""
    return f"udp_multicast/239.74.163.2?port={43200 + 200 * _range + next(_numbers)}&hop_limit=0"


def need_multicast():
    """Skip a test on a computer that has no CAN bus of this kind."""
    try:
        with can.Bus("239.74.163.2", "udp_multicast", port=43199, hop_limit=0) as bus:
            bus.send(can.Message(arbitration_id=0x7FF))
    except (can.CanError, OSError) as error:
        pytest.skip(f"no multicast on this computer: {error}")

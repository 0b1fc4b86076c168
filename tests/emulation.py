"""Starts `mukca emulate` as a program of its own, on loopback addresses that no other test uses."""

import itertools
import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
import pytest

START_SECONDS = 60
_numbers = itertools.count()
_worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))


@dataclass
class Emulation:
    """A running emulator."""

    name: str
    address: str
    """What the driver takes."""
    process: subprocess.Popen[str]
    journal: Path

    @property
    def host(self) -> str:
        """The controller's IP address."""
        return self.address.partition(":")[0]

    def entries(self) -> list[dict[str, Any]]:
        """Return the journal's whole lines."""
        lines = self.journal.read_text(encoding="utf-8").splitlines(keepends=True)
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def received(self) -> list[tuple[str, bytes]]:
        """Return the messages that came in: channel and bytes."""
        return [
            (entry["channel"], bytes.fromhex(entry["received"]))
            for entry in self.entries()
            if "received" in entry
        ]

    def sent(self) -> dict[int, dict[str, Any]]:
        """Return the states that went out, by number."""
        return {entry["sent"]: entry for entry in self.entries() if "sent" in entry}

    def release(self) -> None:
        """Let an arm move that was told to wait."""
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def stop(self) -> None:
        """End it, with its journal whole."""
        self.process.terminate()
        self.process.wait(30)


@contextmanager
def emulated(
    name: str,
    folder: Path,
    *options: str,
    address: str = "",
    command: tuple[str, ...] = (sys.executable, "-m", "mukca"),
) -> Iterator[Emulation]:
    """Run an emulator; by default at an address that nobody else uses."""
    journal = folder / f"journal{next(_numbers)}.jsonl"
    arguments = ("emulate", name, "--json", "--journal", str(journal))
    address = address or own_address(name, options)
    if address.startswith("udp_multicast"):
        need_multicast()
    process = subprocess.Popen(
        [*command, *arguments, "--address", address, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    emulation = None
    try:
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], START_SECONDS)
        line = process.stdout.readline() if ready else ""
        assert line, f"the emulator did not start: {command}"
        told = json.loads(line)["driver"]
        emulation = Emulation(name, told.partition(":")[2], process, journal)
        yield emulation
    finally:
        process.terminate()
        process.wait(30)
        process.communicate()


def own_address(name: str, options: tuple[str, ...] = ()) -> str:
    """Return an address for an emulator that nobody else uses."""
    if name == "piper" or (name == "kinova" and "can" in options):
        return own_bus()
    if name == "kinova":
        return ""
    if name == "kuka":
        return f"{own_host()}?client={own_host()}"
    return own_host()


def own_host() -> str:
    """Return a loopback address that nobody else uses."""
    number = next(_numbers)
    return f"127.{20 + _worker}.{number // 200}.{1 + number % 200}"


def own_bus() -> str:
    """Return a CAN bus that nobody else uses: one by its port, since Linux mixes the groups."""
    return f"udp_multicast/239.74.163.2?port={43200 + 200 * _worker + next(_numbers)}&hop_limit=0"


def need_multicast() -> None:
    """Skip a test on a computer that has no CAN bus of this kind."""
    try:
        with can.Bus("239.74.163.2", "udp_multicast", port=43199, hop_limit=0) as bus:
            bus.send(can.Message(arbitration_id=0x7FF))
    except (can.CanError, OSError) as error:
        pytest.skip(f"no multicast on this computer: {error}")

"""``mukca robots``, ``drivers`` and ``emulate``: models, arms that can be read, and stand-ins."""

import json
import math
import re
import signal
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ....drivers import DriverInfo, list_drivers, try_plugin
from ....drivers.arms import Fault
from ....errors import MukcaError
from ....solver import assessment
from ....solver.identification import robot as models
from ... import emulators
from ...emulators import KINDS, Emulator, FaultInjector, Journal, emulated_arm
from .. import JsonOption, Options, Terminal, argument

KNOWN: dict[str, dict[str, Any]] = json.loads(
    Path(__file__).with_name("robots.json").read_bytes()
)
"""Driver of each robot; and how far its ball comes from its second joint, about [m]."""


class _RobotsListOptions(JsonOption):
    licences: bool = False


def run_robots(options: _RobotsListOptions, terminal: Terminal) -> int:
    """List all shipped robots."""
    robots = [describe(name) for name in models.shipped_robots()]
    terminal.emit({"robots": robots})
    width = max(len(row["name"]) for row in robots)
    for one in robots if not options.json else ():
        repeats = one["repeatability"]
        known = f", repeats to {1e3 * repeats:g} mm" if repeats else ""
        lines = [
            one["title"],
            f"{one['joints']} joints, reach {one['reach']:.2f} m{known}; {one['driver']}",
            f"from {one['source']}",
        ]
        if options.licences:
            licences = ", ".join(one["licences"])
            lines = [licences or "no licence noted; the figures and names are from:"]
            lines += [f"  {source}" for source in one["sources"]]
        for i, line in enumerate(lines):
            terminal.say(f"{'' if i else one['name']:{width}}  {line}")
    return 0


def describe(name: str) -> dict[str, Any]:
    """Return facts on a shipped robot in SI units, most of them from its file's comment."""
    robot = models.load_robot(name)
    comment = robot.text.data.decode().partition("<!--")[2].partition("-->")[0]
    title, _, rest = " ".join(comment.split()).partition(". Lengths in metres")
    sources = re.findall(r"Source of ([^:]*: .*?)(?=(?<!\b[A-Z])\. [A-Z]|\.$|$)", rest)
    arm = assessment.ARMS.get(name)
    return {
        "name": name,
        "title": title.partition(" with a ball")[0]
        .partition(" with its")[0]
        .rstrip(","),
        "joints": len(robot.actuated),
        "reach": KNOWN[name]["reach"],
        "driver": KNOWN[name]["driver"],
        "repeatability": arm.repeatability if arm else None,
        "source": sources[0].partition(": ")[2] if sources else "",
        "sources": sources,
        "licences": sorted(set(re.findall(r"BSD-[23]-Clause|Apache-2\.0|MIT", rest))),
    }


def run_drivers(options: JsonOption, terminal: Terminal) -> int:
    """List all drivers."""
    drivers = [try_plugin(info) for info in list_drivers()]
    terminal.warn(*(info.broken for info in drivers if info.broken))
    terminal.emit({"drivers": [_as_json(info) for info in drivers]})
    width = max(len(info.name) for info in drivers)
    lines = (
        f"{one.name:{width}}  {one.arms} ({one.source}); {_state(one)}"
        for one in drivers
    )
    terminal.say(*lines if not options.json else ())
    return 0


def _state(info: DriverInfo) -> str:
    """Return the packages that a driver needs, and whether they are installed."""
    if info.broken:
        return "BROKEN"
    if info.missing:
        return f"NOT READY: needs {', '.join(info.missing)}, not installed"
    ready = f"ready, with {', '.join(info.needs)}" if info.needs else "ready"
    others = (
        f"{address} with {module}{'' if find_spec(module) else ', NOT installed'}"
        for module, address in info.optional
    )
    return "; ".join([ready, *others])


def _as_json(info: DriverInfo) -> dict[str, object]:
    keys = ("name", "arms", "needs", "missing", "source")
    optional = [
        {"module": name, "address": address, "installed": find_spec(name) is not None}
        for name, address in info.optional
    ]
    plain = {key: getattr(info, key) for key in keys}
    return {**plain, "optional": optional, "broken": info.broken or None}


EMULATORS = {
    name.removesuffix("Emulator").lower(): name
    for name in dir(emulators)
    if name.endswith("Emulator") and name != "Emulator"
}
"""Class of each controller, on the face of the emulators."""
LIST = "\n".join(f"  {kind:<11} {what}" for kind, what in KINDS.items())


class _EmulateOptions(Options):
    controller: str = argument("the controller to play", choices=sorted(EMULATORS))
    version: str | None = None
    address: str = ""
    recording: Path | None = None
    hold: float = 1.0
    move: float = 1.0
    wait: bool = False
    noise: float = 2e-5
    rate: float | None = None
    fault: Sequence[str] = ()
    seed: int = 0
    journal: Path | None = None
    json: bool = False


def run_emulate(options: _EmulateOptions, terminal: Terminal) -> int:
    """Emulate until interrupted or terminated."""
    emulator = open_emulator(options)
    if options.wait:
        emulator.wait_for_line(sys.stdin.fileno())
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        terminal.emit({"driver": emulator.driver_address, "version": emulator.version})
        if not options.json:
            terminal.say(
                f"Emulating {options.controller}, version {emulator.version}.",
                f"Read it with: mukca stream --driver '{emulator.driver_address}'",
                *(["Press Enter to let the arm move."] if options.wait else []),
                "End it with Ctrl-C.",
            )
        emulator.serve()
    except KeyboardInterrupt:
        pass
    finally:
        emulator.close()
        emulator.journal.close()
    return 0


def open_emulator(options: _EmulateOptions) -> Emulator:
    """Return the emulator that was asked for, listening."""
    kind: type[Emulator] = getattr(emulators, EMULATORS[options.controller])
    version = options.version or next(iter(kind.VERSIONS))
    if version not in kind.VERSIONS:
        raise MukcaError(
            f"{options.controller} has no version {version}; one of: {', '.join(kind.VERSIONS)}"
        )
    try:
        faults = [Fault.parse(text, KINDS, math.inf) for text in options.fault]
    except ValueError as error:
        raise MukcaError(str(error)) from None
    for fault in faults:
        if fault.kind not in kind.FAULTS:
            raise MukcaError(
                f"no fault {fault.kind!r} at {options.controller}; "
                f"there are: {', '.join(kind.FAULTS)}"
            )
    journal = Journal(options.journal)
    injector = FaultInjector(faults, options.seed)
    joints, usual_rate = kind.VERSIONS[version]
    rate = usual_rate if options.rate is None else options.rate
    motion = options.hold, options.move
    arm = emulated_arm(joints, rate, motion, options.noise, options.recording)
    try:
        return kind(options.address, version, arm, injector, journal)
    except OSError as error:
        raise MukcaError(f"{options.controller}: cannot listen: {error}") from None

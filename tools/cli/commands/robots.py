"""``mukca robots`` and ``drivers``: the models in the package, and the arms that can be read."""

import json
import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ....drivers import DriverInfo, list_drivers, try_plugin
from ....solver import assessment
from ....solver.identification import robot as models
from .. import JsonOption, Terminal, option

KNOWN: dict[str, dict[str, Any]] = json.loads(
    Path(__file__).with_name("robots.json").read_bytes()
)
"""Driver of each robot; and how far its ball comes from its second joint, about [m]."""


class _RobotsListOptions(JsonOption):
    licences: bool = option(False, "the sources of each model, and their licences")


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
        heads = [one["name"], *[""] * len(lines[1:])]
        terminal.say(
            *(f"{h:{width}}  {line}" for h, line in zip(heads, lines, strict=True))
        )
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
        {
            "module": module,
            "address": address,
            "installed": find_spec(module) is not None,
        }
        for module, address in info.optional
    ]
    plain = {key: getattr(info, key) for key in keys}
    return {**plain, "optional": optional, "broken": info.broken or None}

"""``mukca drivers``: the arms that can be read."""

import argparse

from ...drivers.registry import DriverInfo, list_drivers, try_plugin
from ..terminal import Terminal

_EXAMPLE = """example:
  mukca drivers
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = _EXAMPLE
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """List all drivers."""
    drivers = [try_plugin(info) for info in list_drivers()]
    if arguments.json:
        terminal.emit({"drivers": [_as_json(info) for info in drivers]})
        return 0
    width = max(len(info.name) for info in drivers)
    for info in drivers:
        terminal.say(f"{info.name:{width}}  {_state(info):11}  {info.arms} ({info.source})")
        if info.broken:
            terminal.warn(info.broken)
    return 0


def _state(info: DriverInfo) -> str:
    if info.broken:
        return "broken"
    return "needs " + ", ".join(info.missing) if info.missing else "ready"


def _as_json(info: DriverInfo) -> dict[str, object]:
    return {
        "name": info.name,
        "arms": info.arms,
        "needs": list(info.needs),
        "missing": list(info.missing),
        "broken": info.broken or None,
        "source": info.source,
    }

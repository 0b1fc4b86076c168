"""``mukca drivers``: the arms that can be read."""

from importlib.util import find_spec

from ....drivers import DriverInfo, list_drivers, try_plugin
from .. import JsonOption, Terminal

Options = JsonOption


def run(options: Options, terminal: Terminal) -> int:
    """List all drivers."""
    drivers = [try_plugin(info) for info in list_drivers()]
    terminal.warn(*(info.broken for info in drivers if info.broken))
    terminal.emit({"drivers": [_as_json(info) for info in drivers]})
    width = max(len(info.name) for info in drivers)
    lines = (f"{one.name:{width}}  {one.arms} ({one.source}); {_state(one)}" for one in drivers)
    terminal.say(*lines if not options.json else ())
    return 0


def _state(info: DriverInfo) -> str:
    """Say what a driver needs, and whether it is there."""
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
        {"module": module, "address": address, "installed": find_spec(module) is not None}
        for module, address in info.optional
    ]
    plain = {key: getattr(info, key) for key in keys}
    return {**plain, "optional": optional, "broken": info.broken or None}

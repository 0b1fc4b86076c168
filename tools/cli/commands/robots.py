"""``mukca robots`` and ``drivers``: the models in the package, and the arms that can be read."""

import re
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from ....drivers import DriverInfo, list_drivers, try_plugin
from ....solver import assessment
from ....solver import robot as models
from .. import JsonOption, Terminal

DRIVERS = {
    **dict.fromkeys(("panda", "fr3"), "franka:HOST"),
    "iiwa14": "kuka:HOST",
    **dict.fromkeys(("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e", "ur20"), "ur:HOST"),
    **dict.fromkeys(("gen3", "gen3_lite"), "kinova:kortex://HOST"),
    "piper": "piper:can0",
    "openarm": "damiao:can0",
    **dict.fromkeys(("xarm6", "xarm7", "lite6", "uf850"), "xarm:HOST"),
    **{name: f"feetech:PORT?arm={name}" for name in ("so101", "so100")},
    **{name: f"dynamixel:PORT?arm={name}" for name in ("vx300s", "wx250s", "koch")},
}
"""Driver of each robot; any can be read by way of ROS."""
CONFIGURATIONS = 256
ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class RobotsListOptions(JsonOption):
    """Options of ``mukca robots``."""

    licences: bool = False


def run_robots(options: RobotsListOptions, terminal: Terminal) -> int:
    """List all shipped robots."""
    robots = [describe(name) for name in models.shipped_robots()]
    terminal.emit({"robots": robots})
    width = max(len(one["name"]) for one in robots)
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
        terminal.say(*(f"{h:{width}}  {line}" for h, line in zip(heads, lines, strict=True)))
    return 0


def describe(name: str) -> dict[str, Any]:
    """Return what is worth knowing of a shipped robot, in SI units, by its file's comment."""
    robot = models.load_robot(name)
    comment = robot.text.data.decode().partition("<!--")[2].partition("-->")[0]
    title, _, rest = " ".join(comment.split()).partition(". Lengths in metres")
    sources = re.findall(r"Source of ([^:]*: .*?)(?=(?<!\b[A-Z])\. [A-Z]|\.$|$)", rest)
    arm = assessment.ARMS.get(name)
    return {
        "name": name,
        "title": title.partition(" with a ball")[0].partition(" with its")[0].rstrip(","),
        "joints": len(robot.actuated),
        "reach": reach(robot),
        "driver": DRIVERS.get(name, "ros:HOST"),
        "repeatability": arm.repeatability if arm else None,
        "source": sources[0].partition(": ")[2] if sources else "",
        "sources": sources,
        "licences": sorted(set(re.findall(r"BSD-[23]-Clause|Apache-2\.0|MIT", rest))),
    }


def reach(robot: "models.Robot") -> float:
    """Return how far the ball comes from the second joint [m], about: the best of a search."""
    import numpy as np

    model = models.BallModel(robot, [])
    lower = np.array([max(j.lower, -np.pi) for j in robot.actuated])
    upper = np.array([min(j.upper, np.pi) for j in robot.actuated])
    positions = models.workspace(robot, CONFIGURATIONS)
    positions[:, 0] = 0.0 if lower[0] < 0 < upper[0] else lower[0]
    q = np.eye(1, len(lower))[0] * positions[0, 0]
    frames = models.link_frames(robot.joints, robot.origins.ravel(), q)
    second = robot.joints.index(robot.actuated[1])
    centre = np.asarray(frames[second][1]).ravel()

    def distances(q: "np.ndarray") -> "np.ndarray":
        return np.linalg.norm(model.points(np.empty(0), q) - centre, axis=1)

    best = positions[np.argmax(distances(positions))]
    for _ in range(ROUNDS):
        for joint in range(1, len(best)):
            tries = np.tile(best, (CONFIGURATIONS, 1))
            tries[:, joint] = np.linspace(lower[joint], upper[joint], CONFIGURATIONS)
            best = tries[np.argmax(distances(tries))]
    return float(distances(np.tile(best, (CONFIGURATIONS, 1)))[0])


def run_drivers(options: JsonOption, terminal: Terminal) -> int:
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

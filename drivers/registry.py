"""From a driver's name to the driver: one table, and one group of entry points for plug-ins.

Nothing that belongs to a vendor is imported before its driver is opened. A third party adds an
arm by an entry point of the group ``mukca.drivers`` in a package of its own::

    [project.entry-points."mukca.drivers"]
    myarm = "mypackage.driver:MyArm"
"""

import importlib
import inspect
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec

from .driver import Driver, DriverError, Reason

__all__ = [
    "DRIVERS",
    "ENTRY_POINT_GROUP",
    "DriverInfo",
    "list_drivers",
    "open_driver",
    "try_plugin",
]

ENTRY_POINT_GROUP = "mukca.drivers"


@dataclass(frozen=True)
class DriverInfo:
    """One line of ``mukca drivers``."""

    name: str
    target: str
    """Where the class is, ``module:Class``."""
    arms: str
    """Which arms it reads, and how."""
    needs: tuple[str, ...] = ()
    """Python modules that it imports beyond the standard library."""
    source: str = "mukca"
    """The package that provides it, with its version where it is a plug-in."""
    broken: str = ""
    """What is wrong with a plug-in, where it was tried; see :func:`try_plugin`."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Needed modules that are not installed."""
        return tuple(module for module in self.needs if find_spec(module) is None)


DRIVERS: dict[str, DriverInfo] = {
    info.name: info
    for info in (
        DriverInfo("franka", "mukca.drivers.franka:Franka", "Panda, FR3: FCI"),
        DriverInfo(
            "kinova", "mukca.drivers.kinova:Kinova", "Gen2, JACO: RS-485, CAN; Gen3: Kortex"
        ),
        DriverInfo("kuka", "mukca.drivers.kuka:Kuka", "LBR iiwa, LBR Med: FRI"),
        DriverInfo("mock", "mukca.drivers.mock:Mock", "a simulated arm: replays a recording"),
        DriverInfo("piper", "mukca.drivers.piper:Piper", "AgileX Piper: CAN", needs=("can",)),
        DriverInfo(
            "ros", "mukca.drivers.ros:Ros", "any arm in ROS: rosbridge", needs=("roslibpy",)
        ),
        DriverInfo("ur", "mukca.drivers.ur:Ur", "UR3 to UR20, CB3 and e-series: RTDE"),
    )
}


def list_drivers() -> list[DriverInfo]:
    """Return the drivers of the table, then those of installed plug-ins, by name."""
    plugins = entry_points(group=ENTRY_POINT_GROUP)
    return [*DRIVERS.values(), *(_plugin(point) for point in sorted(plugins, key=_name))]


def try_plugin(info: DriverInfo) -> DriverInfo:
    """Import a plug-in's driver, and describe it by its own first line, or as broken.

    What mukca itself provides is returned as it is: its vendors' packages load only on use.
    """
    if info.name in DRIVERS and DRIVERS[info.name] is info:
        return info
    try:
        told = inspect.getdoc(_load(info)) or "plug-in"
    except DriverError as error:
        return replace(info, broken=str(error))
    return replace(info, arms=told.splitlines()[0])


def open_driver(name: str, address: str, joint_names: Sequence[str] | None = None) -> Driver:
    """Connect to a robot.

    Args:
        name: A name of the table, or of an installed plug-in.
        address: Where the robot is, in the driver's notation.
        joint_names: The model's actuated joints in chain order, or None without a model.

    Raises:
        DriverError: No such driver, a package it needs is missing, or it cannot connect.
    """
    infos = {info.name: info for info in reversed(list_drivers())}
    if name not in infos:
        raise DriverError(
            Reason.BAD_ADDRESS,
            f"no driver is called {name!r}; there are: {', '.join(sorted(infos))}",
        )
    return _load(infos[name])(address, joint_names)


def _load(info: DriverInfo) -> type[Driver]:
    """Import a driver's class, naming the driver in every trouble."""
    module, _, attribute = info.target.partition(":")
    try:
        loaded = getattr(importlib.import_module(module), attribute)
    except ImportError as error:
        raise DriverError(
            Reason.MISSING_PACKAGE,
            f"driver {info.name!r} of {info.source} needs {error.name}: {error}",
        ) from None
    except Exception as error:  # a plug-in may fail in any way; it is named and stops no other
        raise DriverError(
            Reason.MISSING_PACKAGE, f"driver {info.name!r} of {info.source} is broken: {error!r}"
        ) from error
    if not (isinstance(loaded, type) and issubclass(loaded, Driver)):
        raise DriverError(
            Reason.MISSING_PACKAGE,
            f"driver {info.name!r} of {info.source}: {info.target} is no subclass of Driver",
        )
    return loaded


def _plugin(point: EntryPoint) -> DriverInfo:
    package = point.dist
    source = f"{package.name} {package.version}" if package else "a plug-in"
    return DriverInfo(point.name, point.value, "plug-in", source=source)


def _name(point: EntryPoint) -> str:
    return point.name

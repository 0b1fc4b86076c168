"""From a driver's name to the driver: one table, and one group of entry points for plug-ins.

Nothing that belongs to a vendor is imported before its driver is opened. A third party adds an
arm by an entry point of the group ``mukca.drivers`` in a package of its own::

    [project.entry-points."mukca.drivers"]
    myarm = "mypackage.driver:MyArm"
"""

import importlib
import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from .driver import Driver, DriverError, Reason

__all__ = ["DRIVERS", "ENTRY_POINT_GROUP", "DriverInfo", "list_drivers", "open_driver"]

ENTRY_POINT_GROUP = "mukca.drivers"


@dataclass(frozen=True)
class DriverInfo:
    """One line of ``mukca drivers``."""

    name: str
    target: str
    """Where the class is: ``module:Class``."""
    arms: str
    """Which arms it reads, and how."""
    needs: tuple[str, ...] = ()
    """Python modules that it imports beyond the standard library."""
    source: str = "mukca"
    """The package that provides it, with its version where it is a plug-in."""
    problem: str | None = None
    """Why it cannot be used, or None."""


DRIVERS: dict[str, DriverInfo] = {
    info.name: info
    for info in (
        DriverInfo("mock", "mukca.drivers.mock:Mock", "a simulated arm: replays a recording"),
    )
}

"""Opens a driver by its name: those that mukca brings, and those of installed plug-ins.

A driver's module, and the vendor's package that it may need, are imported only when it is opened.
Another package adds an arm by an entry point of the group ``mukca.drivers``::

    [project.entry-points."mukca.drivers"]
    myarm = "mypackage.driver:MyArm"
"""

import importlib
import inspect
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any

from ..errors import MukcaError, read_beside
from .driver import Driver, DriverError, ModelNames, Reason


@dataclass(frozen=True)
class DriverInfo:
    """Description of a driver before it is imported: one line of ``mukca drivers``."""

    name: str
    target: str
    """The class, ``module:Class``."""
    arms: str
    """The arms that it reads, and over what."""
    needs: Sequence[str] = ()
    """Python modules that it imports beyond the standard library."""
    optional: Sequence[tuple[str, str]] = ()
    """Modules that only some addresses need: each with how those addresses begin."""
    source: str = "mukca"
    """The package that provides it, with its version where it is a plug-in."""
    broken: str = ""
    """Error of a plug-in that cannot be imported, where that was tried; see :func:`try_plugin`."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Those of :attr:`needs` that are not installed."""
        return tuple(module for module in self.needs if find_spec(module) is None)


_OWN = read_beside(__file__, "arms.json")
DRIVERS: dict[str, DriverInfo] = {row["name"]: DriverInfo(**row) for row in _OWN}


def list_drivers() -> list[DriverInfo]:
    """Return all drivers: first mukca's own, then those of installed plug-ins by name."""
    others = (
        DriverInfo(entry.name, entry.target, "plug-in", source=entry.source)
        for entry in installed("drivers")
    )
    return [*DRIVERS.values(), *others]


def try_plugin(info: DriverInfo) -> DriverInfo:
    """Import a plug-in's driver, to describe it by its docstring's first line or as broken.

    mukca's own drivers are returned as they are, without being imported.
    """
    if info.name in DRIVERS and DRIVERS[info.name] is info:
        return info
    try:
        description = inspect.getdoc(_load(info)) or "plug-in"
    except DriverError as error:
        return replace(info, broken=str(error))
    return replace(info, arms=description.splitlines()[0])


def open_driver(
    driver: str, address: str | None = None, joint_names: ModelNames = None
) -> Driver:
    """Connect to a robot, to read its joint states.

    ::

        with mukca.open_driver("franka:172.16.0.2") as driver:
            state = driver.read(timeout=1.0)

    The connection only reads: nothing is ever sent that could move the arm.

    Args:
        driver: ``NAME[:ADDRESS]``, as after ``mukca record --driver``; ``mukca drivers`` lists
            the names, and each driver's page in docs/ says what its addresses look like.
        address: The address by itself; ``driver`` is then the name alone.
        joint_names: The model's actuated joints in chain order; the robot must have as many.
            None without a model: the driver then names the joints itself.

    Returns:
        The open connection: a context manager, and an iterator over all states.

    Raises:
        DriverError: There is no such driver, a package that it needs is missing, it cannot
            connect, or the robot has other joints than the model.
    """
    name = str(driver)
    if address is None:
        name, _, address = name.partition(":")
    infos = DRIVERS  # to look for plug-ins takes a while
    if name not in infos:
        infos = {info.name: info for info in reversed(list_drivers())}
    if name not in infos:
        raise Reason.BAD_ADDRESS(
            f"no driver is called {name!r}; there are: {', '.join(sorted(infos))}"
        )
    return _load(infos[name])(address, joint_names)


def _load(info: DriverInfo) -> type[Driver]:
    """Import a driver's class; every error names the driver and its package."""
    try:
        loaded = load(info, "driver")
    except PluginError as error:
        raise Reason.MISSING_PACKAGE(str(error)) from error
    if not (isinstance(loaded, type) and issubclass(loaded, Driver)):
        raise Reason.MISSING_PACKAGE(
            f"driver {info.name!r} of {info.source}: {info.target} is no subclass of Driver"
        )
    return loaded


OURS = "mukca"
"""Source of what mukca brings."""


class PluginError(MukcaError):
    """An addition of a package cannot be imported; the line names the package and the reason."""


@dataclass(frozen=True)
class Entry:
    """One thing that can be used by its name."""

    name: str
    target: str
    """The object, ``module:NAME``."""
    line: str
    """Description of it, in one line."""
    source: str = OURS
    """The package that provides it, with its version where it is a plug-in."""


def installed(kind: str) -> list[Entry]:
    """Return what installed packages add of a kind, such as ``drivers``, by name."""
    from importlib.metadata import entry_points

    entries: list[Entry] = []
    for point in entry_points(group=f"mukca.{kind}"):
        line, source = "plug-in", "a plug-in"
        if package := point.dist:
            source = f"{package.name} {package.version}"
            if "Summary" in package.metadata:
                line = package.metadata["Summary"]
        entries.append(Entry(point.name, point.value, line, source))
    return sorted(entries, key=lambda entry: entry.name)


def load(entry: "Entry | DriverInfo", kind: str) -> Any:
    """Import an entry's object; ``kind`` is the word for it in messages, such as ``driver``.

    Raises:
        PluginError: A plug-in's module, or a package that any needs, cannot be imported. What else
            is wrong in a module of mukca is a defect, and is raised as it is.
    """
    what = f"{kind} {entry.name!r} of {entry.source}"
    module, _, attribute = entry.target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way
        if isinstance(error, ImportError) and error.name:
            raise PluginError(f"{what} needs {error.name}: {error}") from None
        if entry.source == OURS:
            raise
        raise PluginError(f"{what} is broken: {error!r}") from error

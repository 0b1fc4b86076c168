"""What installed packages add to mukca: drivers, verbs, and formats of export.

A package names an object in an entry point of a group ``mukca.KIND``, as in::

    [project.entry-points."mukca.exports"]
    heron = "mukca_heron.export:write"

What mukca brings stands in tables of the same form. To list an entry imports nothing: its line is
the description of its package. Its module is imported when it is used.
"""

import importlib
from dataclasses import dataclass
from typing import Any

from ..errors import MukcaError

OURS = "mukca"
"""Source of what mukca brings."""


class PluginError(MukcaError):
    """What a package adds cannot be imported; the line names the package and the reason."""


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
        if (package := point.dist) is not None:
            source = f"{package.name} {package.version}"
            if "Summary" in package.metadata:
                line = package.metadata["Summary"]
        entries.append(Entry(point.name, point.value, line, source))
    return sorted(entries, key=lambda entry: entry.name)


def load(entry: Entry, kind: str) -> Any:
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

"""The formats that a calibration can be written in."""

import importlib
from dataclasses import dataclass
from typing import Protocol

from .export import Exported, Request

__all__ = ["FORMATS", "Format", "export"]


class Module(Protocol):
    """What the module of a format offers."""

    def export(self, request: Request) -> Exported:
        """Return the files.

        Raises:
            ExportError: The calibration cannot be written so; nothing was written.
        """
        ...


@dataclass(frozen=True)
class Format:
    """One format: who reads it, and which module writes it."""

    module: str
    line: str
    takes: tuple[str, ...] = ()
    """Which options, of those that not every format has, it understands."""


FORMATS: dict[str, Format] = {
    "c": Format("c_code", "C99 source of the full model, for controllers, .c", ("flange",)),
    "dh": Format("dh", "Denavit-Hartenberg table, .json or .csv"),
    "mdh": Format("dh", "modified Denavit-Hartenberg table (Craig's), .json or .csv"),
}
"""By the word that ``--to`` takes. A new format is a line here, and its module."""


def export(request: Request) -> Exported:
    """Return the files of an export; see :class:`Module`."""
    name = FORMATS[request.format].module
    module: Module = importlib.import_module(f".{name}", __package__)  # pyright: ignore[reportAssignmentType]
    return module.export(request)

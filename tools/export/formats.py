"""The formats that a calibration can be written in."""

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from .export import Exported, Request


class Module(Protocol):
    """What the module of a format offers."""

    def export(self, request: "Request") -> "Exported":
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
    "urdf": Format("urdf", "calibrated URDF, with tools that --tool adds", ("flange", "tool")),
    "xacro": Format("xacro", "macro for the joint origins of any robot's xacro, .xacro"),
    "ur": Format("vendor_yaml", "kinematics file of ur_description, .yaml", ("like",)),
    "franka": Format("vendor_yaml", "kinematics.yaml of franka_description, .yaml"),
    "xarm": Format("vendor_yaml", "kinematics file of xarm_description, .yaml"),
    "lerobot": Format(
        "lerobot",
        "lerobot's calibration file (--like), its zeros shifted, .json",
        ("like", "servos"),
    ),
    "mjcf": Format(
        "mjcf", "MuJoCo model of your own (--like), its bodies corrected", ("like", "joints")
    ),
    "c": Format("c_code", "C99 source of the full model, for controllers, .c", ("flange",)),
    "dh": Format("dh", "Denavit-Hartenberg table, .json or .csv"),
    "mdh": Format("dh", "modified Denavit-Hartenberg table (Craig's), .json or .csv"),
}
"""By the word that ``--to`` takes. A new format is a line here, and its module."""


def export(request: "Request") -> "Exported":
    """Return the files of an export; see :class:`Module`."""
    name = FORMATS[request.format].module
    module: Module = importlib.import_module(f".{name}", __package__)  # pyright: ignore[reportAssignmentType]
    return module.export(request)

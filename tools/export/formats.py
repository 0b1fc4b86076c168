"""The formats that a calibration can be written in."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """One format: the module that writes it, its line of help, and its options."""

    module: str
    line: str
    takes: tuple[str, ...] = ()
    """Names of the :class:`.request.ExportOptions` that it has."""


FORMATS: dict[str, Format] = {
    "urdf": Format("urdf", "calibrated URDF, with tools that --tool adds", ("flange", "tools")),
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
    "c": Format(
        "c_code", "C99 source of the full model, for controllers, .c", ("flange", "payload")
    ),
    "dh": Format("dh", "Denavit-Hartenberg table, .json or .csv"),
    "mdh": Format("dh", "modified Denavit-Hartenberg table (Craig's), .json or .csv"),
}
"""By the word that ``--to`` takes. A new format is a line here, and its module."""

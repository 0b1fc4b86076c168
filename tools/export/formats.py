"""The formats that a calibration can be written in, and writing it in one of them."""

import importlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...solver.calibration import check_keywords
from ...solver.results import refuse_existing, write_files
from .request import Exported, ExportError, ExportOptions, Request, identify

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ...solver.calibration import Calibration


@dataclass(frozen=True)
class Format:
    """One format: the function that writes it, its line of help, and its options."""

    writer: str
    line: str
    takes: tuple[str, ...] = ()
    """Names of the :class:`.request.ExportOptions` that it has."""


FORMATS: dict[str, Format] = {
    "urdf": Format(
        "ros.write_urdf", "calibrated URDF, with tools that --tool adds", ("flange", "tools")
    ),
    "xacro": Format("ros.write_xacro", "macro for the joint origins of any robot's xacro, .xacro"),
    "ur": Format("ros.write", "kinematics file of ur_description, .yaml", ("like",)),
    "franka": Format("ros.write", "kinematics.yaml of franka_description, .yaml"),
    "xarm": Format("ros.write", "kinematics file of xarm_description, .yaml"),
    "lerobot": Format(
        "lerobot.write",
        "lerobot's calibration file (--like), its zeros shifted, .json",
        ("like", "servos"),
    ),
    "mjcf": Format(
        "mjcf.write", "MuJoCo model of your own (--like), its bodies corrected", ("like", "joints")
    ),
    "c": Format(
        "c_code.write", "C99 source of the full model, for controllers, .c", ("flange", "payload")
    ),
    "dh": Format("dh.write", "Denavit-Hartenberg table, .json or .csv"),
    "mdh": Format("dh.write", "modified Denavit-Hartenberg table (Craig's), .json or .csv"),
}
"""By the word that ``--to`` takes. A new format is a line here, and its module."""


def export(
    calibration: "Calibration",
    to: str,
    out: str | Path,
    *,
    serial_number: str | None = None,
    force: bool = False,
    **options: "Unpack[ExportOptions]",
) -> Exported:
    """Write a calibration as another program reads it, for instance as a MuJoCo model.

    What the format cannot say is in the result's ``losses``, with what it costs at the ball.

    Args:
        calibration: The calibration.
        to: The format, one of :data:`FORMATS`, as in ``mjcf``.
        out: The file to write; some formats write others beside it.
        serial_number: The arm's; None for the one noted while recording.
        force: Overwrite what is there.
        options: Those of :class:`.request.ExportOptions` that the format has.

    Returns:
        The files written, by name, and what to know about them.

    Raises:
        ExportError: No such format, or the calibration cannot be written so.
        UsageError: No such option.
        OutputError: A file is there already, or cannot be written.
    """
    if to not in FORMATS:
        raise ExportError(f"no format {to!r}; there are: {', '.join(FORMATS)}")
    check_keywords("export", options, list(ExportOptions.__annotations__))
    for option, value in options.items():
        if value and option not in FORMATS[to].takes:
            takers = ", ".join(
                name for name, format_info in FORMATS.items() if option in format_info.takes
            )
            word = "tool" if option == "tools" else option
            raise ExportError(f"--{word} is for --to {takers}, not for {to}")
    file = Path(out)
    if file.is_dir():
        raise ExportError(f"--out {file}: is a folder; name a file")
    request = Request(to, calibration, identify(calibration, serial_number), file, options)
    module, _, function = FORMATS[to].writer.partition(".")
    write = getattr(importlib.import_module(f".{module}", __package__), function)
    exported: Exported = write(request)
    refuse_existing(file.parent, exported.files, force=force)
    written = write_files(file.parent, exported.files)
    return replace(exported, outputs={name: str(path) for name, path in written.items()})

"""The formats that a calibration can be written in, and writing it in one of them."""

import importlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import read_json
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
    takes: Sequence[str] = ()
    """Names of the :class:`.request.ExportOptions` that it has."""


_TABLE = read_json(Path(__file__).with_name("formats.json"))
FORMATS: dict[str, Format] = {name: Format(**fields) for name, fields in _TABLE.items()}
"""By the word that ``--to`` takes. A new format is a line of the file, and its module."""


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
            takers = [
                name for name, format_ in FORMATS.items() if option in format_.takes
            ]
            word = "tool" if option == "tools" else option
            raise ExportError(f"--{word} is for --to {', '.join(takers)}, not for {to}")
    file = Path(out)
    if file.is_dir():
        raise ExportError(f"--out {file}: is a folder; name a file")
    request = Request(
        to, calibration, identify(calibration, serial_number), file, options
    )
    module, _, function = FORMATS[to].writer.partition(".")
    write = getattr(importlib.import_module(f".{module}", __package__), function)
    exported: Exported = write(request)
    refuse_existing(file.parent, exported.files, force=force)
    written = write_files(file.parent, exported.files)
    return replace(
        exported, outputs={name: str(path) for name, path in written.items()}
    )

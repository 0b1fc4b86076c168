"""Writing a calibration in one of the formats."""

import importlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from ...solver.calibration import check_keywords
from ...solver.results import refuse_existing, write_files
from .formats import FORMATS
from .request import Exported, ExportError, ExportOptions, Request, identify

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ...solver.calibration import Calibration


class Writer(Protocol):
    """The module of a format."""

    def write(self, request: Request) -> Exported:
        """Return the files; an ExportError says why the calibration cannot be written so."""
        ...


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
        to: The format, one of :data:`.formats.FORMATS`, as in ``mjcf``.
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
    _check_options(to, options)
    file = Path(out)
    if file.is_dir():
        raise ExportError(f"--out {file}: is a folder; name a file")
    request = Request(to, calibration, identify(calibration, serial_number), file, options)
    writer = importlib.import_module(f".{FORMATS[to].module}", __package__)
    exported = cast("Writer", writer).write(request)
    refuse_existing(file.parent, exported.files, force=force)
    written = write_files(file.parent, exported.files)
    return replace(exported, outputs={name: str(path) for name, path in written.items()})


def _check_options(to: str, options: ExportOptions) -> None:
    """Refuse a format that there is not, and an option that it does not have."""
    if to not in FORMATS:
        raise ExportError(f"no format {to!r}; there are: {', '.join(FORMATS)}")
    check_keywords("export", options, list(ExportOptions.__annotations__))
    for option, value in options.items():
        if value and option not in FORMATS[to].takes:
            takers = ", ".join(name for name, each in FORMATS.items() if option in each.takes)
            word = "tool" if option == "tools" else option
            raise ExportError(f"--{word} is for --to {takers}, not for {to}")

"""The formats that a calibration can be written in, and writing it in one of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...drivers import Entry, installed, load
from ...errors import read_beside
from ...solver.calibration import check_keywords
from ...solver.results import refuse_existing, write_files
from .request import Exported, ExportError, ExportOptions, Request, identify

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ...solver.calibration import Calibration


@dataclass(frozen=True)
class Format(Entry):
    """One format: the function from a :class:`.request.Request` to its files, and its options."""

    takes: Sequence[str] = ()
    """Names of the :class:`.request.ExportOptions` that it has."""
    endings: Sequence[str] = ()
    """Endings of its file; none where any will do."""


_TABLE = read_beside(__file__, "formats.json")
FORMATS = {name: Format(name, **fields) for name, fields in _TABLE.items()}
"""mukca's own, by the word that ``--to`` takes. A new one is a line of the file, and its module."""


def format_table() -> dict[str, Format]:
    """Return all formats by name: mukca's own, then those of installed packages."""
    entries = installed("exports")
    others = {e.name: Format(e.name, e.target, e.line, e.source) for e in entries}
    return FORMATS | others | FORMATS


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
        to: The format, one of :func:`format_table`, as in ``mjcf``.
        out: The file to write; some formats write others beside it.
        serial_number: The arm's; None for the one noted while recording.
        force: Overwrite what is there.
        options: Those of :class:`.request.ExportOptions` that the format has.

    Returns:
        The files written, by name, and what to know about them.

    Raises:
        ExportError: No such format, or the calibration cannot be written so.
        UsageError: No such option.
        PluginError: The format is of a package that cannot be imported.
        OutputError: A file is there already, or cannot be written.
    """
    # To look for plug-ins takes a while.
    table = FORMATS if to in FORMATS else format_table()
    if to not in table:
        raise ExportError(f"no format {to!r}; there are: {', '.join(table)}")
    check_keywords("export", options, list(ExportOptions.__annotations__))
    for option, value in options.items():
        if value and option not in table[to].takes:
            takers = ", ".join(name for name in table if option in table[name].takes)
            word = "tool" if option == "tools" else option
            raise ExportError(f"--{word} is for --to {takers}, not for {to}")
    file = Path(out)
    if file.is_dir():
        raise ExportError(f"--out {file}: is a folder; name a file")
    identity = identify(calibration, serial_number)
    request = Request(
        to,
        calibration,
        identity,
        file,
        options,
    )
    if table[to].endings:
        request.require_ending(*table[to].endings)
    exported: Exported = load(table[to], "format")(request)
    refuse_existing(file.parent, exported.files, force=force)
    written = write_files(file.parent, exported.files).items()
    return replace(exported, outputs={name: str(path) for name, path in written})

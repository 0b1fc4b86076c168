"""A defect of mukca itself: one line for the user, and a report that helps to mend it."""

import os
import platform
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path
from shlex import join

from ..._version import __version__
from .console import write_error

DEFECT = 70
"""Exit status, as EX_SOFTWARE of sysexits.h."""
SHOW = "MUKCA_TRACEBACK"
"""Environment variable by which the traceback is shown instead, for those who mend it."""


def report_defect(error: Exception, words: Sequence[str]) -> int:
    """Write a report of an unexpected exception, say where it lies, and return the exit status.

    The report has version, command and traceback. Samples are not in it, only what the message of
    the exception itself quotes.
    """
    if SHOW in os.environ:
        raise error
    verb = " ".join(["mukca", *words[:1]])
    lines = [
        f"mukca {__version__}, Python {platform.python_version()}, {platform.platform()}",
        f"command: {join(['mukca', *words])}",
        f"folder: {_folder()}",
        "",
        "".join(traceback.format_exception(error)),
    ]
    try:
        number, file = tempfile.mkstemp(prefix="mukca-defect-", suffix=".txt")
        os.close(number)
        Path(file).write_text(
            "\n".join(lines), encoding="utf-8", errors="backslashreplace"
        )
        advice = f"please send us {file}, which holds the command and the traceback, no samples"
    except OSError as reason:
        advice = f"no report could be written ({reason.strerror}); {SHOW}=1 shows the traceback"
    place = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}"
    write_error(
        f"{verb}: stopped by a defect of mukca ({where}), ours to mend: {advice}"
    )
    return DEFECT


def _folder() -> str:
    try:
        return str(Path.cwd())
    except OSError:
        return "(gone)"

"""Writing results: never over what is there unless told so, and never half."""

import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from ...errors import MukcaError


class OutputError(MukcaError):
    """Results cannot be written where they were asked for."""


def refuse_existing(folder: Path, names: Iterable[str] | None = None, *, force: bool) -> None:
    """See that an output folder may be written, before the work begins.

    Args:
        folder: The folder.
        names: The files that will be written, if others may lie beside them.
        force: Whether to overwrite.

    Raises:
        OutputError: The folder, or one of the files, exists and ``force`` is not given, or the
            folder is none.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: exists and is no folder; choose another --out")
    if names is not None:
        taken = [] if force else [folder / name for name in names if (folder / name).exists()]
        if taken:
            raise OutputError(f"{taken[0]}: exists; choose another --out, or --force to overwrite")
    elif folder.exists() and not force:
        raise OutputError(f"{folder}: exists; choose another --out, or --force to overwrite")


def write_files(folder: Path, contents: Mapping[str, bytes]) -> dict[str, Path]:
    """Write files into a folder, each under a temporary name first, then renamed.

    Args:
        folder: Made with its parents where missing.
        contents: What to write, by file name.

    Returns:
        The paths written, by file name.

    Raises:
        OutputError: The disk is full, or the folder may not be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            _write(folder / name, content)
    except OSError as error:
        raise OutputError(
            f"{error.filename or folder}: cannot be written: {error.strerror}"
        ) from None
    return {name: folder / name for name in contents}


def _write(file: Path, content: bytes) -> None:
    handle, temporary = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)  # noqa: PTH101  (mkstemp makes it private)
        Path(temporary).replace(file)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise

"""Files that survive a crash: appended, replaced and locked; and the errors of recordings."""

import os
import sys
from contextlib import suppress
from pathlib import Path

from ..errors import MukcaError


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


class EmptyRecordingError(RecordingError):
    """A file that holds no configuration yet."""


APPEND: int = os.O_APPEND | getattr(os, "O_BINARY", 0)
"""To open a file to which bytes are appended as they are; Windows would change ends of lines."""
_BEYOND = 1 << 30


def append_bytes(descriptor: int, data: bytes, *, sync: bool = True) -> None:
    """Append to an open file, and wait until it is on the disk, or do not (``sync``).

    Raises:
        OSError: Not all could be written, as on a full disk; what was written is cut off again.
    """
    size = os.fstat(descriptor).st_size
    try:
        while data:
            data = data[os.write(descriptor, data) :]
        if sync:
            os.fsync(descriptor)
    except OSError:
        with suppress(OSError):
            os.ftruncate(descriptor, size)
            os.fsync(descriptor)
        raise


def replace_file(file: Path, content: bytes) -> None:
    """Write a file in one step: a crash leaves the old one, or the new one.

    Raises:
        OSError: It cannot be written; the old one is there, and nothing else.
    """
    temporary = file.with_name(f".{file.name}.tmp")
    try:
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(file)
    except OSError:
        with suppress(OSError):
            temporary.unlink()
        raise
    sync_folder(file.parent)


def sync_folder(folder: Path) -> None:
    """Return once the names in a folder are on the disk."""
    if sys.platform == "win32":
        return  # folders cannot be opened there; NTFS keeps a journal of names
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def lock_file(descriptor: int) -> None:
    """Lock an open file until it is closed.

    Raises:
        BlockingIOError: Another program holds it.
    """
    if sys.platform == "win32":
        import msvcrt

        # What is locked there, nobody else can read.
        os.lseek(descriptor, _BEYOND, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError(*error.args) from None
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

"""Files that survive a crash: appended, replaced and locked."""

import errno
import os
import sys
import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import reason_of, require_file
from .recording_error import RecordingError

APPEND: int = os.O_APPEND | getattr(os, "O_BINARY", 0)
"""To open a file to which bytes are appended as they are; Windows would change ends of lines."""
_BEYOND = 1 << 30
PATIENCE = 5.0
"""Time in which another program ends a change of a file [s]; only a recorder takes longer."""


def append_bytes(
    descriptor: int,
    data: bytes,
    *,
    sync: bool = True,
) -> None:
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


def replace_files(contents: Mapping[Path, bytes]) -> None:
    """Write files whole beside their places, then put them there one by one, in this order.

    A crash leaves each file as it was, or new.

    Raises:
        OSError: One cannot be written; of several the reason says which are new by then.
    """
    # A name that no other program takes for the same file.
    temporaries = {
        file: file.with_name(f".{file.name}.{os.urandom(8).hex()}") for file in contents
    }
    replaced: list[str] = []
    file = Path()
    try:
        for file, temporary in temporaries.items():
            # It is not there yet; a link of its name is an error, too.
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | APPEND
            descriptor = os.open(temporary, flags, 0o666)
            try:
                append_bytes(descriptor, contents[file])
            finally:
                os.close(descriptor)
        for file, temporary in temporaries.items():
            temporary.replace(file)
            replaced.append(str(file))
        for folder in {file.parent for file in contents}:
            sync_folder(folder)
    except BaseException as error:
        for temporary in temporaries.values():
            with suppress(OSError):
                temporary.unlink()
        if isinstance(error, OSError):
            error.filename = str(file)
            if len(contents) > 1:
                as_before = [
                    str(file) for file in contents if str(file) not in replaced
                ]
                state = f"new: {', '.join(replaced)}; as before: {', '.join(as_before) or 'none'}"
                if not replaced:
                    state = "nothing was changed"
                error.strerror = f"{state}; reason: {error.strerror}"
        raise


def make_folder(folder: Path) -> list[Path]:
    """Make a folder and its parents, each one on the disk before the next is made in it.

    Returns:
        The new folders, the innermost first.
    """
    if folder.exists():
        return []
    new_parents = make_folder(folder.parent)
    folder.mkdir(exist_ok=True)
    sync_folder(folder.parent)
    return [folder, *new_parents]


@contextmanager
def refused(what: str) -> Generator[None]:
    """Turn an error of the system into a RecordingError; ``what`` begins its message."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"{what}: {reason_of(error)}") from None


def sync_folder(folder: Path) -> None:
    """Return once the names in a folder are on the disk, where its file system can say so."""
    if sys.platform == "win32":
        return  # folders cannot be opened there; NTFS keeps a journal of names
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except PermissionError:
        return  # a folder to write to, not to list
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # said by network drives that cannot
            raise
    finally:
        os.close(descriptor)


@contextmanager
def locked(file: Path | None) -> Generator[None]:
    """Keep other programs that lock a file from it meanwhile, where there is one.

    Raises:
        BlockingIOError: Another program holds it, after :data:`PATIENCE`, too.
    """
    if file is None:
        yield
        return
    require_file(file, None)
    descriptor = os.open(file, os.O_RDONLY)
    try:
        deadline = time.monotonic() + PATIENCE
        while True:
            try:
                lock_file(descriptor)
                break
            except BlockingIOError:
                if time.monotonic() >= deadline:
                    raise
            time.sleep(0.0005)  # seldom free for longer while another writes on and on
        yield
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

"""Files that others wrote, opened by one function: no device, no pipe, nothing without end."""

import errno
import os
import stat
from pathlib import Path

from .errors import MukcaError, shortened

LARGEST_FILE = 200_000_000
"""Size that no table, model, calibration or image exceeds [bytes]."""
_KINDS = {
    stat.S_IFDIR: (errno.EISDIR, "a folder"),
    stat.S_IFIFO: (errno.ESPIPE, "a pipe"),
    stat.S_IFSOCK: (errno.ENXIO, "a socket of the system"),
    stat.S_IFCHR: (errno.ENODEV, "a device"),
    stat.S_IFBLK: (errno.ENODEV, "a device"),
}


class RefusedFileError(MukcaError, OSError):
    """A path is no file, or a file is too large to read; whoever handles missing files has it."""

    def __str__(self) -> str:
        return shortened(f"{self.filename}: {self.strerror}")


def require_file(file: Path, largest: int | None = LARGEST_FILE) -> None:
    """See that a path, or what it links to, is a file, before anything opens it.

    Args:
        file: The path.
        largest: The size that is read at most [bytes]; None for files that are read in parts.

    Raises:
        OSError: There is nothing, or a :class:`RefusedFileError`, it is no file or is too large.
    """
    status = file.stat()
    if not stat.S_ISREG(status.st_mode):
        number, kind = _KINDS.get(stat.S_IFMT(status.st_mode), (errno.EINVAL, "no file"))
        raise RefusedFileError(number, f"is {kind}", str(file))
    if largest is not None and status.st_size > largest:
        words = f"holds {status.st_size / 1e6:,.1f} MB; at most {largest / 1e6:,.0f} MB are read"
        raise RefusedFileError(errno.EFBIG, words, str(file))


def read_bytes(file: str | os.PathLike[str]) -> bytes:
    """Return the content of a file; see :func:`require_file` for what is refused."""
    path = Path(file)
    require_file(path)
    return path.read_bytes()

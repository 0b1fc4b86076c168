"""Errors of recordings, and the lines that messages name."""

from collections.abc import Sequence

from ..errors import MukcaError

LISTED = 8
"""Most lines that a remark names."""


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


class EmptyRecordingError(RecordingError):
    """A file that holds no configuration yet."""


class UnitError(RecordingError):
    """A column is in a unit that its numbers cannot have."""


class NoColumnsError(RecordingError):
    """A table has no columns of joints, or of x, y, z."""


def listed(lines: Sequence[object]) -> str:
    """Return the first lines of some, between commas, as messages name them."""
    return ", ".join(map(str, lines[:LISTED])) + ", .." * (len(lines) > LISTED)

"""Errors of recordings."""

from ..errors import MukcaError


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


class EmptyRecordingError(RecordingError):
    """A file that holds no configuration yet."""


class UnitError(RecordingError):
    """A column is in a unit that its numbers cannot have."""


class NoColumnsError(RecordingError):
    """A table has no columns of joints, or of x, y, z."""

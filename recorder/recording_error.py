"""Errors of recordings."""

from ..errors import MukcaError


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


class EmptyRecordingError(RecordingError):
    """A file that holds no configuration yet."""

"""The error of arguments that cannot be, in words that hold for Python and the command line."""

from .. import MukcaError

__all__ = ["UsageError"]


class UsageError(MukcaError):
    """Arguments that cannot be, or do not go together."""

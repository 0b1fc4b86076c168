"""A pseudo-terminal: a serial line whose settings nobody checks."""

import os
import tty

from ...errors import MukcaError


def open_line(address: str, emulator: str) -> tuple[int, str]:
    """Open a line; return the emulator's end of it, and what to open at the other.

    Raises:
        MukcaError: An address was given, which such a line cannot have.
    """
    if address:
        raise MukcaError(f"{emulator} opens a terminal of its own; leave --address out")
    own, other = os.openpty()
    tty.setraw(own)
    tty.setraw(other)
    return own, os.ttyname(other)

"""A disk that is full, as far as a process can tell."""

import resource
import sys
from contextlib import contextmanager
from unittest.mock import patch


@contextmanager
def full_disk(size):
    """Let no file of this process grow beyond a size [bytes]."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        with patch.object(sys, "dont_write_bytecode", True):  # else modules would be cut off
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

"""A disk that is full, as far as a process can tell."""

import resource
from contextlib import contextmanager


@contextmanager
def full_disk(size):
    """Let no file of this process grow beyond a size [bytes]."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

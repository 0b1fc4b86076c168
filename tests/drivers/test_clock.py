"""Waiting: for any descriptor, however many files are open."""

import fcntl
import os
import resource

import pytest

from mukca.drivers import clock


@pytest.fixture
def high():
    """The ends of a pipe, the first of which has a number that select() does not take."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < 2000:
        pytest.skip("so many files cannot be open here")
    resource.setrlimit(resource.RLIMIT_NOFILE, (2000, hard))
    reader, writer = os.pipe()
    number = fcntl.fcntl(reader, fcntl.F_DUPFD, 1500)
    yield number, writer
    for file in (reader, writer, number):
        os.close(file)
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_descriptor_beyond_1023_is_waited_for(high):
    reader, writer = high
    assert clock.wait([reader], 0.01) == []
    os.write(writer, b"x")
    assert clock.wait([reader], 10) == [reader]


def test_a_closed_source_is_told():
    reader, writer = os.pipe()
    os.close(writer)
    with os.fdopen(reader) as file:
        pass
    with pytest.raises((OSError, ValueError)):
        clock.wait([file], 0.01)

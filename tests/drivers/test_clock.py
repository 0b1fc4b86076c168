"""Waiting: for any descriptor, however many files are open, and whatever the wall's time is."""

import fcntl
import os
import resource
import time

import pytest
from emulator_programs import need_multicast, own_bus

from mukca.drivers import clock
from mukca.drivers.transport import CanBus, parse_can_address


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


@pytest.mark.parametrize("address", ["virtual/silent", None], ids=["virtual", "multicast"])
def test_a_silent_bus_is_waited_for_no_longer_while_the_wall_s_time_is_set_back(
    address, monkeypatch
):
    need_multicast()
    bus = CanBus(parse_can_address(address or own_bus()))
    asked = read = clock.now()
    back = 0.0

    def wall_time():  # set back during a wait, not between two reads of one poll
        nonlocal read, back
        back = 40.0 if clock.now() - read > 0.2 else back
        read = clock.now()
        return time.time() - back

    monkeypatch.setattr("can.bus.time", wall_time)
    assert bus.receive(asked + 0.3) is None
    assert 0.3 <= clock.now() - asked < 30
    bus.close()

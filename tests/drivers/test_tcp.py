"""Messages taken off a TCP connection."""

import time

import pytest
from driver_errors import refused
from listeners import saying

from mukca.drivers.transport import TcpStream, parse_endpoint


@pytest.fixture
def stream():
    opened = []

    def open_stream(address):
        opened.append(TcpStream(parse_endpoint(address, 1), "is it on?"))
        return opened[-1]

    yield open_stream
    for stream in opened:
        stream.close()


def soon():
    return time.monotonic() + 5


def test_lines_are_taken_one_by_one_however_they_come(stream):
    with saying(b"one\ntw", b"o\n\nthree\n", pause=0.01) as address:
        lines = stream(address)
        assert [lines.take_line(soon()) for _ in range(4)] == [b"one", b"two", b"", b"three"]


def test_bytes_without_a_line_break_are_no_lines(stream):
    with saying(bytes(100), pause=1e-3) as address, refused("PROTOCOL") as caught:
        stream(address).take_line(soon())
    assert "4096 bytes without a line break" in str(caught.value)

"""mukca's contract for drivers, and what is the Heron's own."""

import math
import socket
import threading
from collections.abc import Callable, Iterator

import pytest
from mukca_heron.driver import Heron, decode_line
from mukca_heron.simulator import serve, state_line

from mukca.drivers import DriverContract, DriverError, JointState, Reason


class TestHeron(DriverContract):
    """The contract, over the simulator."""

    driver = Heron
    joints = 4
    nobody = "127.0.0.1:9"
    wrong = "host:port"

    @pytest.fixture(scope="class")
    @classmethod
    def address(cls) -> Iterator[str]:
        """A simulator on a free port."""
        server = socket.create_server(("127.0.0.1", 0))
        threading.Thread(target=serve, args=(server,), daemon=True).start()
        yield f"127.0.0.1:{server.getsockname()[1]}"
        server.shutdown(socket.SHUT_RDWR)
        server.close()

    @pytest.fixture
    def sent(self) -> Callable[[], list[JointState]]:
        """What the simulator sends to everyone who connects, from the first state on."""
        return lambda: [
            decode_line(state_line(number), joints=4) for number in range(5000)
        ]


def test_units() -> None:
    """Degrees become radians, torques stay."""
    state = decode_line(b"STATE 7 0.035 0 90 -180 45 0 1 2 3", joints=4)
    assert state.stamp == 0.035
    assert state.position == pytest.approx((0, math.pi / 2, -math.pi, math.pi / 4))
    assert state.effort == (0, 1, 2, 3)


@pytest.mark.parametrize(
    "line",
    [b"", b"STATE", b"STATE 1 0 1 2 3 4", b"STATE 1 0 1 2 3 4 0 0 0 x", b"\xff 1 2"],
)
def test_what_is_no_state(line: bytes) -> None:
    """A malformed line never becomes a joint angle."""
    with pytest.raises(ValueError):
        decode_line(line, joints=4)


def answering(server: socket.socket, *lines: bytes) -> str:
    """Send lines to the first client, which then finds the connection ended."""

    def answer() -> None:
        with server.accept()[0] as client:
            client.sendall(b"".join(lines))

    threading.Thread(target=answer, daemon=True).start()
    host, port = server.getsockname()
    return f"{host}:{port}"


def test_gaps_and_malformed_lines_are_counted() -> None:
    """Numbers tell what was missed; the end of the connection is told."""
    not_a_number = b"STATE 3 0.015 0 0 0 0 0 0 0 nan\n"
    lines = (
        b"HERON 4\n",
        state_line(1),
        b"STATE 2 garbled\n",
        not_a_number,
        state_line(5),
    )
    server = socket.create_server(("127.0.0.1", 0))
    with server, Heron(answering(server, *lines)) as driver:
        driver.read(1)
        driver.read(1)
        assert (driver.missed, driver.rejected) == (3, 2)
        with pytest.raises(DriverError) as caught:
            driver.read(1)
    assert caught.value.reason is Reason.UNREACHABLE


def test_what_is_no_heron_is_told() -> None:
    """A greeting of something else is PROTOCOL."""
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        pytest.raises(DriverError) as caught,
    ):
        Heron(answering(server, b"SSH-2.0\n"))
    assert caught.value.reason is Reason.PROTOCOL

"""The Heron: it greets on TCP port 5005, then sends its state as lines of text, 200 a second.

::

    HERON 4                                                          how many joints it has
    STATE <number> <seconds> <4 angles, degrees> <4 torques, N m>    from then on

Torques are what each joint exerts on the arm beyond it.

Address: ``HOST[:PORT]``.
"""

import math
import time
from collections.abc import Sequence

from mukca.drivers import Driver, DriverError, JointState, Reason, match_joints
from mukca.drivers.address import open_tcp, parse_endpoint

PORT = 5005
GREETING_SECONDS = 2.0
LONGEST_LINE = 400


def decode_line(line: bytes, joints: int) -> tuple[int, JointState]:
    """Return a line's number and state.

    Raises:
        ValueError: It is no such line, or a number in it is none.
    """
    word, number, *numbers = line.decode("ascii").split()
    values = [float(text) for text in numbers]
    if word != "STATE" or len(values) != 1 + 2 * joints or not all(map(math.isfinite, values)):
        raise ValueError("no line with a state")
    position = tuple(math.radians(degrees) for degrees in values[1 : 1 + joints])
    return int(number), JointState(values[0], position, tuple(values[1 + joints :]))


class Heron(Driver):
    """A Heron that streams its state."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT)
        self._where = str(endpoint)
        self._buffer = b""
        self._last: int | None = None
        self._tcp = open_tcp(endpoint, "is the Heron switched on?")
        try:
            self._joints = self._greeting()
            self._joint_names = match_joints(joint_names, self._joints, "the Heron")
        except BaseException:
            self.close()  # a constructor that fails leaves nothing open
            raise

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints, from base to flange."""
        return self._joint_names

    def read(self, timeout: float) -> JointState:
        """Return the next state."""
        deadline = time.monotonic() + timeout
        while True:
            try:
                number, state = decode_line(self._line(deadline), self._joints)
            except ValueError:
                self.rejected += 1
                continue
            if self._last is not None:
                self.missed += number - self._last - 1
            self._last = number
            return state

    def close(self) -> None:
        """End the connection."""
        self._tcp.close()

    def _greeting(self) -> int:
        words = self._line(time.monotonic() + GREETING_SECONDS).split()
        if len(words) != 2 or words[0] != b"HERON" or not words[1].isdigit():
            raise DriverError(Reason.PROTOCOL, f"what listens at {self._where} is no Heron")
        return int(words[1])

    def _line(self, deadline: float) -> bytes:
        """Return the next line without its end, waiting for it."""
        while b"\n" not in self._buffer:
            if len(self._buffer) > LONGEST_LINE:
                self.close()
                raise DriverError(Reason.PROTOCOL, f"the Heron at {self._where} sends no lines")
            try:
                self._tcp.settimeout(max(0.0, deadline - time.monotonic()))
                received = self._tcp.recv(4096)
            except (TimeoutError, BlockingIOError):
                raise DriverError(
                    Reason.SILENT, f"no state from the Heron at {self._where}"
                ) from None
            except OSError:
                received = b""
            if not received:
                raise DriverError(
                    Reason.UNREACHABLE, f"the connection to the Heron at {self._where} has ended"
                )
            self._buffer += received
        line, _, self._buffer = self._buffer.partition(b"\n")
        return line

"""The Heron: it greets on TCP port 5005, then sends its state as lines of text, 200 a second.

::

    HERON 4                                                          how many joints it has
    STATE <number> <seconds> <4 angles, degrees> <4 torques, N m>    from then on

Torques are what each joint exerts on the links beyond it.

Address: ``HOST[:PORT]``.
"""

import math
import time
from collections.abc import Sequence

from mukca.drivers import (
    DriverError,
    JointState,
    Reason,
    ValidatingDriver,
    match_joints,
)
from mukca.drivers.transport import TcpStream, parse_endpoint

PORT = 5005
PERIOD = 0.005  # s between two states
GREETING_SECONDS = 2.0


def decode_line(line: bytes, joints: int) -> JointState:
    """Return the state in a line.

    Raises:
        ValueError: It is no such line, or a number in it is none.
    """
    word, _, *numbers = line.decode("ascii").split()
    seconds, *values = [float(text) for text in numbers]
    if word != "STATE" or len(values) != 2 * joints:
        raise ValueError("no line with a state")
    position = tuple(math.radians(degrees) for degrees in values[:joints])
    return JointState(seconds, position, tuple(values[joints:]))


class Heron(ValidatingDriver):
    """A Heron that streams its state."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT)
        super().__init__(f"the Heron at {endpoint}", PERIOD)
        self._tcp = TcpStream(endpoint, "is the Heron switched on?")
        with self._closed_on_error():  # a constructor that fails leaves nothing open
            self._joint_names = match_joints(joint_names, self._greeting(), "the Heron")

    def _receive(self, deadline: float) -> JointState:
        return decode_line(self._tcp.take_line(deadline), len(self._joint_names))

    def _disconnect(self) -> None:
        self._tcp.close()

    def _greeting(self) -> int:
        words = self._tcp.take_line(time.monotonic() + GREETING_SECONDS).split()
        if len(words) != 2 or words[0] != b"HERON" or not words[1].isdigit():
            raise DriverError(Reason.PROTOCOL, f"what answers is no Heron: {words}")
        return int(words[1])

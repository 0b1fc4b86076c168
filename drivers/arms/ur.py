"""Universal Robots, CB3 and e-series, UR3 to UR20: RTDE, outputs only.

RTDE streams over TCP, at 500 Hz from an e-series controller and 125 Hz from a CB3. Efforts are
None, since these arms measure motor currents; ``effort=OUTPUT`` asks the controller for one of its
outputs of six numbers instead. ``target_moment`` is computed by its model and not measured: a hand
on the arm does not show in it. Signs were not proven.

Address: ``HOST[:PORT][?rate=HZ&effort=OUTPUT]``.
"""

import struct
from collections.abc import Sequence

from .. import DriverError, JointState, Reason, ValidatingDriver, clock, match_joints
from ..transport import CONNECT_SECONDS, TcpStream, parse_endpoint
from .rtde import (
    CONTROLLER_VERSION,
    DATA,
    PROTOCOL_VERSION,
    SETUP_OUTPUTS,
    START,
    Recipe,
    decode_recipe,
    encode_package,
    setup_payload,
    take_package,
)

PORT = 30004
JOINTS = 6
E_SERIES = 5  # first major version of its software
TRIED = "software 3.15, 5.11 and 10.7 was tried"
SLOW, FAST = 125, 500  # Hz, of a CB3 and of an e-series controller


class Ur(ValidatingDriver):
    """A UR arm that streams its state."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("rate", "effort"))
        super().__init__(f"the robot at {endpoint}")
        self._joint_names = match_joints(joint_names, JOINTS, "a UR arm")
        wanted_rate = endpoint.options.positive("rate", FAST)
        self._tcp = TcpStream(endpoint, "is the robot's controller started?")
        with self._closed_on_error():
            self.rate = min(wanted_rate, self._fastest())
            """States per second."""
            self._period = 1 / self.rate
            self._recipe = self._start(self.rate, endpoint.options.get("effort"))

    def _receive(self, deadline: float) -> JointState:
        state, self.status = self._recipe.decode(self._next_package(DATA, deadline))
        return state

    def _disconnect(self) -> None:
        self._tcp.close()

    def _fastest(self) -> int:
        """Agree on the protocol; return the greatest rate of this controller [Hz]."""
        if self._ask(PROTOCOL_VERSION, struct.pack(">H", 2)) != b"\x01":
            raise DriverError(
                Reason.PROTOCOL, f"{self._where} does not speak RTDE version 2: {TRIED}"
            )
        version = self._ask(CONTROLLER_VERSION)
        if len(version) != 16:
            raise DriverError(Reason.PROTOCOL, f"{self._where} sends a malformed version")
        return FAST if struct.unpack(">4I", version)[0] >= E_SERIES else SLOW

    def _start(self, rate: float, effort: str | None) -> Recipe:
        """Ask for the outputs, and for the stream to start; return the outputs' recipe."""
        outputs = self._ask(SETUP_OUTPUTS, setup_payload(rate, effort))
        try:
            recipe = decode_recipe(outputs, effort)
        except ValueError as error:
            raise DriverError(Reason.PROTOCOL, f"{self._where} sends {error}") from None
        if self._ask(START) != b"\x01":
            raise DriverError(Reason.WRONG_MODE, f"{self._where} refuses to start")
        return recipe

    def _ask(self, kind: int, payload: bytes = b"") -> bytes:
        """Send a request and return the payload of its reply."""
        try:
            self._tcp.send(encode_package(kind, payload))
            return self._next_package(kind, clock.now() + CONNECT_SECONDS)
        except DriverError as error:
            if error.reason is Reason.PROTOCOL:
                raise
            raise DriverError(
                Reason.BUSY,
                f"{self._where} took the connection but did not answer: is RTDE switched on, "
                "and does another program use all of its connections?",
            ) from None

    def _next_package(self, kind: int, deadline: float) -> bytes:
        """Return the payload of the next package of a type; others, as texts, are left out."""
        while True:
            came, payload = self._tcp.take(take_package, deadline)
            if came == kind:
                return payload
            if clock.now() > deadline:
                raise DriverError(Reason.SILENT, f"no state from {self._where}, but other packages")

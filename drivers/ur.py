"""Universal Robots, CB3 and e-series, UR3 to UR20: RTDE, outputs only.

RTDE streams over TCP port 30004, at 500 Hz from an e-series controller and 125 Hz from a CB3.
It is read here without a vendor's package, since ur-rtde's receive interface keeps the latest
state alone: a reader that must not lose one cannot use it. The requests are those of ur-rtde.

Efforts are None: these arms measure motor currents, and no torque in N m. ``effort=OUTPUT`` asks
the controller for one of its own outputs of six numbers instead. ``target_moment`` is what its
model computes, not what it measures, so that a hand on the arm does not show in it. The sign of
such an output was not proven.

Address: ``HOST[:PORT][?rate=HZ&effort=OUTPUT]``.
"""

import struct
from collections.abc import Sequence

from . import clock
from .address import CONNECT_SECONDS, open_tcp, parse_endpoint
from .driver import Driver, DriverError, JointState, Reason, match_joints
from .rtde import (
    CONTROLLER_VERSION,
    DATA,
    PROTOCOL_VERSION,
    SETUP_OUTPUTS,
    START,
    Recipe,
    RtdeState,
    decode_recipe,
    encode_package,
    setup_payload,
    take_package,
)

__all__ = ["PORT", "Ur"]

PORT = 30004
JOINTS = 6
E_SERIES = 5  # first major version of its software
SLOW, FAST = 125, 500  # Hz, of a CB3 and of an e-series controller
STATES_BETWEEN = 1.5  # periods apart: beyond it a state is missing


class Ur(Driver):
    """A UR arm that streams its state."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("rate", "effort"))
        self._joint_names = match_joints(joint_names, JOINTS, "a UR arm")
        self._where = str(endpoint)
        self._wanted_rate = endpoint.options.positive("rate", FAST)
        self._effort = endpoint.options.get("effort")
        self._stream = bytearray()
        self._last: RtdeState | None = None
        self._tcp = open_tcp(endpoint, "is the robot's controller started?")
        try:
            self._recipe = self._set_up()
        except BaseException:
            self.close()
            raise

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The arm's six joints, from base to flange."""
        return self._joint_names

    def read(self, timeout: float) -> JointState:
        """Return the next state; see :meth:`Driver.read`."""
        deadline = clock.now() + timeout
        while True:
            try:
                state = self._recipe.decode(self._next(DATA, deadline))
            except ValueError as error:
                raise self._unusable(error) from None
            if self._is_next(state):
                self._last, self.status = state, state.status
                return JointState(state.timestamp, state.position, state.effort)
            self.rejected += 1
            if clock.now() > deadline:
                raise DriverError(Reason.SILENT, f"only old states from the robot at {self._where}")

    def close(self) -> None:
        """End the connection."""
        self._tcp.close()

    def _set_up(self) -> Recipe:
        """Agree on the protocol, ask for the outputs, and start."""
        if self._ask(PROTOCOL_VERSION, struct.pack(">H", 2)) != b"\x01":
            raise DriverError(
                Reason.PROTOCOL, f"the robot at {self._where} does not speak RTDE version 2"
            )
        version = self._ask(CONTROLLER_VERSION)
        if len(version) != 16:
            raise self._unusable(ValueError("a malformed controller version"))
        fastest = FAST if struct.unpack(">4I", version)[0] >= E_SERIES else SLOW
        self._rate = min(self._wanted_rate, fastest)
        outputs = self._ask(SETUP_OUTPUTS, setup_payload(self._rate, self._effort))
        try:
            recipe = decode_recipe(outputs, self._effort)
        except ValueError as error:
            raise self._unusable(error) from None
        if self._ask(START) != b"\x01":
            raise DriverError(Reason.WRONG_MODE, f"the robot at {self._where} refuses to start")
        return recipe

    def _ask(self, kind: int, payload: bytes = b"") -> bytes:
        """Send a request and return the payload of its reply."""
        try:
            self._tcp.sendall(encode_package(kind, payload))
            return self._next(kind, clock.now() + CONNECT_SECONDS)
        except (OSError, DriverError) as error:
            if isinstance(error, DriverError) and error.reason is Reason.PROTOCOL:
                raise
            raise DriverError(
                Reason.BUSY,
                f"{self._where} took the connection but did not answer: is RTDE switched on, "
                "and does another program use all of its connections?",
            ) from None

    def _next(self, kind: int, deadline: float) -> bytes:
        """Return the payload of the next package of a type; others, as texts, are left out."""
        while True:
            got, payload = self._receive(deadline)
            if got == kind:
                return payload
            if clock.now() > deadline:
                raise DriverError(
                    Reason.SILENT, f"no state from the robot at {self._where}, but other packages"
                )

    def _receive(self, deadline: float) -> tuple[int, bytes]:
        """Return the next package, waiting for it."""
        while True:
            try:
                package = take_package(self._stream)
            except ValueError as error:
                raise self._unusable(error) from None
            if package is not None:
                return package
            try:
                if not clock.wait([self._tcp], max(0.0, deadline - clock.now())):
                    raise DriverError(Reason.SILENT, f"no state from the robot at {self._where}")
                received = self._tcp.recv(1 << 16)
            except (OSError, ValueError):  # a closed socket cannot be waited for
                raise self._ended() from None
            if not received:
                raise self._ended()
            self._stream += received

    def _is_next(self, state: RtdeState) -> bool:
        """Tell whether a state is later than the last one, and count those between."""
        if self._last is None:
            return True
        periods = (state.timestamp - self._last.timestamp) * self._rate
        if periods > STATES_BETWEEN:
            self.missed += round(periods) - 1
        return periods > 0

    def _unusable(self, error: ValueError) -> DriverError:
        """Close a connection whose bytes make no sense: a stream cannot be found again."""
        self.rejected += 1
        self.close()
        return DriverError(Reason.PROTOCOL, f"the robot at {self._where} sends {error}")

    def _ended(self) -> DriverError:
        return DriverError(Reason.UNREACHABLE, f"the robot at {self._where} ended the connection")

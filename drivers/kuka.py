"""KUKA LBR iiwa and LBR Med: the Fast Robot Interface, monitored.

The controller sends first, once a Sunrise application has opened an FRI session to this
computer. A reply to every so many messages keeps the session; it is a header alone and carries
no command. A session that goes on to command the arm is left at once.

Efforts are the measured joint torques. Their sign was not proven: record at rest, compare it
with the model's gravity torque, and set ``effort=-1`` if they oppose each other.

Address: ``HOST[:PORT][?bind=LOCAL&effort=-1]``. HOST is the controller; PORT (30200) is the UDP
port that the application sends to, opened here on LOCAL, by default on all interfaces.
"""

from collections.abc import Iterator, Sequence

from . import clock
from .address import parse_endpoint, resolve
from .datagrams import DatagramSocket
from .driver import Driver, DriverError, JointState, Reason, match_joints
from .fri import Session, StateMessage, decode_message, encode_reply

__all__ = ["PORT", "Kuka"]

PORT = 30200
FIRST_MESSAGE_SECONDS = 3.0
RESTARTED = 100  # a sequence counter so far behind belongs to a new session
COUNTER = 1 << 32


class Kuka(Driver):
    """An iiwa or Med whose FRI session is open in monitoring mode."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("bind", "effort"))
        self._sign = endpoint.options.sign("effort")
        self._where = endpoint.host
        self._malformed = self._replies = self._unanswered = 0
        self._last: StateMessage | None = None
        self._waiting: StateMessage | None = None
        """The message that told how many joints there are, not yet read."""
        local = (endpoint.options.get("bind", "0.0.0.0"), endpoint.port)  # noqa: S104
        self._udp = DatagramSocket(local, resolve(endpoint.host), self._count_rejected)
        try:
            self._joint_names = self._await_session(joint_names, endpoint.port)
        except BaseException:
            self.close()
            raise

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The arm's joints, from base to flange."""
        return self._joint_names

    def read(self, timeout: float) -> JointState:
        """Return the next state; see :meth:`Driver.read`."""
        if self._waiting is not None:
            message, self._waiting = self._waiting, None
            return self._state(message)
        for message in self._messages(clock.now() + timeout):
            if message.position:
                return self._state(message)
        last = f"; its session was {self.status}" if self._last else ""
        raise DriverError(
            Reason.SILENT, f"no FRI message from {self._where} for {timeout:g} s{last}"
        )

    def close(self) -> None:
        """Stop listening; the controller sees the replies end."""
        self._udp.close()

    def _await_session(self, joint_names: Sequence[str] | None, port: int) -> tuple[str, ...]:
        """Wait for the first message with joints, and match them with the model's."""
        for message in self._messages(clock.now() + FIRST_MESSAGE_SECONDS):
            if message.position:
                self._waiting = message
                return match_joints(joint_names, len(message.position), "the KUKA arm")
        if self._last is not None:
            raise DriverError(
                Reason.WRONG_MODE,
                f"the FRI session of {self._where} is {self.status} and tells no joint angles",
            )
        if self._malformed:
            raise DriverError(
                Reason.PROTOCOL, f"what {self._where} sends to UDP port {port} is not FRI"
            )
        raise DriverError(
            Reason.UNREACHABLE,
            f"no FRI message from {self._where} on UDP port {port}: start the Sunrise "
            "application that opens FRI to this computer (docs/kuka.md)",
        )

    def _messages(self, deadline: float) -> Iterator[StateMessage]:
        """Yield messages in order, each answered if an answer is due, until time is up."""
        for datagram, source in self._udp.until(deadline):
            try:
                message = decode_message(datagram)
            except ValueError:
                self._malformed += 1
                self._count_rejected()
                continue
            if not self._is_next(message):
                self._count_rejected()
                continue
            self._last = message
            self.status = f"{message.session.name.lower().replace('_', ' ')}, {message.quality}"
            self._refuse_command(message)
            self._answer(message, source)
            yield message

    def _is_next(self, message: StateMessage) -> bool:
        """Tell whether a message follows the last one, and count those between."""
        if self._last is None:
            return True
        ahead = (message.sequence - self._last.sequence) % COUNTER
        if 0 < ahead < COUNTER // 2:
            self.missed += ahead - 1
            return True
        return -ahead % COUNTER > RESTARTED

    def _refuse_command(self, message: StateMessage) -> None:
        if message.session >= Session.COMMANDING_WAIT:
            self.close()
            raise DriverError(
                Reason.WRONG_MODE,
                f"the FRI session of {self._where} is in {message.session.name}: it expects "
                "commands, and nothing here sends any; run an application that only monitors",
            )

    def _answer(self, message: StateMessage, source: tuple[str, int]) -> None:
        """Reply to each receiveMultiplier-th message, never when idle."""
        if message.session is Session.IDLE:
            return
        self._unanswered += 1
        if self._unanswered >= message.receive_multiplier:
            self._udp.send(encode_reply(self._replies, message.sequence, message.framed), source)
            self._replies = (self._replies + 1) % COUNTER
            self._unanswered = 0

    def _state(self, message: StateMessage) -> JointState:
        effort = message.torque and tuple(self._sign * torque for torque in message.torque)
        return JointState(message.stamp, message.position, effort)

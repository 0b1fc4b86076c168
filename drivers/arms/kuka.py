"""KUKA LBR iiwa and LBR Med: the Fast Robot Interface, monitored.

The controller sends first, and expects answers, each a header without a command. A session that
commands the arm is left at once. Measured torques oppose the gravity torque: their sign is turned,
unless ``effort=1`` keeps it.

Address: ``HOST[:PORT][?bind=LOCAL&effort=1]``; PORT (30200) is opened here, on LOCAL.
"""

from .. import (
    DriverError,
    JointState,
    ModelNames,
    Reason,
    ValidatingDriver,
    match_joints,
)
from ..transport import DatagramSocket, parse_endpoint, resolve
from .fri import Session, StateMessage, decode_message, encode_reply

PORT = 30200
FIRST_MESSAGE_SECONDS = 3.0
RESTARTED = 100  # a sequence counter further behind than this belongs to a new session
LONGEST_GAP = (
    100_000  # messages: a counter further ahead tells nothing of what is missing
)
COUNTER = 1 << 32


class Kuka(ValidatingDriver):
    """An iiwa or Med whose FRI session is open in monitoring mode."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("bind", "effort"))
        super().__init__(f"the controller at {endpoint.host}")
        self._sign = endpoint.options.sign("effort", -1)
        self._sequence: int | None = None
        self._replies = self._unanswered = 0
        local = (endpoint.options.get("bind", "0.0.0.0"), endpoint.port)  # noqa: S104
        self._udp = DatagramSocket(local, resolve(endpoint.host), self._count_rejected)
        with self._closed_on_error():
            count = self._await_session(endpoint.port)
            self._joint_names = match_joints(joint_names, count, "the KUKA arm")

    def _receive(self, deadline: float) -> JointState:
        for datagram, source in self._udp.until(deadline):
            message = decode_message(datagram)
            self._follow(message)
            # A reply is due to each receiveMultiplier-th message, and none when idle.
            expects = message.session is not Session.IDLE
            self._unanswered += expects
            if expects and self._unanswered >= message.receive_multiplier:
                reply = encode_reply(self._replies, message.sequence, message.framed)
                self._udp.send(reply, source)
                self._replies = (self._replies + 1) % COUNTER
                self._unanswered = 0
            if message.position:
                effort = message.torque and tuple(
                    self._sign * torque for torque in message.torque
                )
                return JointState(message.stamp, message.position, effort)
        last = f"; its session was {self.status}" if self.status else ""
        raise self._silence(deadline, "FRI message with joint angles", last)

    def _disconnect(self) -> None:
        self._udp.close()

    def _await_session(self, port: int) -> int:
        """Wait for the first message with joints; return their number."""
        try:
            return len(self._await_first(FIRST_MESSAGE_SECONDS).position)
        except DriverError as error:
            if error.reason not in (Reason.SILENT, Reason.PROTOCOL):
                raise
        if self.status:
            raise Reason.WRONG_MODE(
                f"the FRI session of {self._where} is {self.status} and tells no joint angles"
            )
        if self._useless:
            raise Reason.PROTOCOL(
                f"what {self._where} sends to UDP port {port} is not FRI of a version known here: "
                "1.11 to 1.16, 2.5 and 2.7 were tried"
            )
        raise Reason.UNREACHABLE(
            f"no FRI message from {self._where} on UDP port {port}: start the Sunrise "
            "application that opens FRI to this computer (the documentation's page on KUKA has it)"
        )

    def _follow(self, message: StateMessage) -> None:
        """Count the messages that are missing before this one; leave a session that commands."""
        if self._sequence is not None:
            ahead = (
                message.sequence - self._sequence + COUNTER // 2
            ) % COUNTER - COUNTER // 2
            if -RESTARTED <= ahead <= 0:
                raise ValueError("an FRI message that is not later than the one before")
            if ahead < 0:
                self._begin_anew()
            elif ahead <= LONGEST_GAP:
                self.missed += ahead - 1
        self._sequence = message.sequence
        self.status = (
            f"{message.session.name.lower().replace('_', ' ')}, {message.quality}"
        )
        if message.session >= Session.COMMANDING_WAIT:
            raise Reason.WRONG_MODE(
                f"the FRI session of {self._where} is in {message.session.name}: it expects "
                "commands, and nothing here sends any; run an application that only monitors"
            )

"""KUKA's controller: an FRI session over UDP that monitors, ready once a reply has come."""

import struct
import zlib

from ...drivers import JointState
from ...drivers.transport import parse_endpoint
from .arm import COMMON_KINDS
from .emulator import Emulator, Version
from .ports import STRANGER, UdpPort

MONITORING_WAIT, MONITORING_READY, COMMANDING_ACTIVE = 1, 2, 4
START_OF_CLOCK = 1_700_000_000


class KukaEmulator(Emulator):
    """An iiwa whose Sunrise application has opened FRI of one version."""

    VERSIONS = dict.fromkeys(("1.15", "1.11", "1.14", "1.16", "2.5", "2.7"), Version(7, 200.0))
    FAULTS = (*COMMON_KINDS, "stranger", "version", "commanding")

    def listen(self, address: str) -> None:
        """Bind the controller's UDP port; the session's client is on the same port."""
        endpoint = parse_endpoint(
            address, 30200, options=("client", "multiplier"), default_host="127.0.0.2"
        )
        self._client = (endpoint.options.get("client", "127.0.0.1"), endpoint.port)
        self._multiplier = endpoint.options.integer("multiplier", 1)
        self._udp = UdpPort(self, (endpoint.host, endpoint.port), self._reply)
        self.driver_address = f"kuka:{self._udp.address}?bind={self._client[0]}"
        self._stranger = UdpPort(self, STRANGER)
        self._replies = 0

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send one monitoring message."""
        self.emit(self._udp.send, self._encode(number, state, moment), moment, self._client)
        if self.faults.is_active("stranger", moment):
            wrong = JointState(0, tuple(q + 0.1 for q in state.position), state.effort)
            self._stranger.send(self._encode(number, wrong, moment), self._client)

    def _encode(self, number: int, state: JointState, moment: float) -> bytes:
        session = MONITORING_READY if self._replies else MONITORING_WAIT
        if self.faults.is_active("commanding", moment):
            session = COMMANDING_ACTIVE
        identifier = 0x245199 if self.faults.is_active("version", moment) else 0x245142
        return encode_message(
            self.version,
            header=(identifier, number, max(0, self._replies - 1)),
            connection=(session, 3, round(1000 / self.arm.rate), self._multiplier),
            state=state,
            nanoseconds=number * round(1e9 / self.arm.rate),
        )

    def _reply(self, _: bytes) -> None:
        """Count a reply; the client counts its replies from 0."""
        self._replies += 1
        self.begin()


def encode_message(
    version: str,
    header: tuple[int, int, int],
    connection: tuple[int, int, int, int],
    state: JointState,
    nanoseconds: int,
) -> bytes:
    """Return an FRI monitoring message.

    Header: identifier, sequence counter, reflected sequence counter. Connection: session state,
    quality, send period [ms], receive multiplier. The clock counts since the controller's start.
    """
    q, tau = state.position, state.effort or (0.0,) * len(state.position)
    monitor = nested(1, doubles(q)) + nested(2, doubles(tau))
    if version.startswith("1."):
        monitor += nested(3, doubles(q))
    monitor += nested(4, doubles(tau)) + nested(5, doubles((0.0,) * len(q)))
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    monitor += nested(15, numbers({1: START_OF_CLOCK + seconds, 2: rest}))
    drives = b"".join(numbers({5: 2}) for _ in q)
    body = nested(1, numbers(dict(enumerate(header, 1))))
    body += nested(2, numbers({1: len(q), 2: 0}) + drives + numbers({6: 0, 7: 0}))
    body += nested(3, monitor)
    body += nested(4, numbers(dict(enumerate(connection, 1))))
    body += nested(5, numbers({10: 0, 11: 0}) + b"\x61" + struct.pack("<d", 1.0))
    if version == "2.7":
        return struct.pack("<I", len(body)) + body + struct.pack("<I", zlib.crc32(body))
    return body + nested(15, b"")


def numbers(fields: dict[int, int]) -> bytes:
    """Return protobuf varint fields by number."""
    return b"".join(varint(number << 3) + varint(value) for number, value in fields.items())


def doubles(values: tuple[float, ...]) -> bytes:
    """Return a JointValues message, unpacked as the controller writes it."""
    return b"".join(b"\x09" + struct.pack("<d", value) for value in values)


def nested(number: int, message: bytes) -> bytes:
    """Return a protobuf field that holds a message."""
    return varint(number << 3 | 2) + varint(len(message)) + message


def varint(value: int) -> bytes:
    """Return a protobuf varint."""
    head = bytearray()
    while value >= 1 << 7:
        head.append(1 << 7 | value & 127)
        value >>= 7
    return bytes([*head, value])

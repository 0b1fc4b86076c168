"""Controllers that send datagrams: Franka's FCI of server versions 3 to 10, and KUKA's FRI.

FCI is field by field as libfranka's header, proven against libfranka 0.9.2 (version 5) and 0.21.3
(version 10). An FRI session monitors, and is ready once a reply has come.
"""

import struct
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import starmap

from ...drivers import JointState
from ...drivers.arms import framed, nested, numbers
from ...drivers.transport import parse_endpoint
from ...errors import read_beside
from .arm import COMMON_KINDS
from .emulator import Emulator, Version
from .ports import STRANGER, TcpServer, UdpPort

FRANKA = read_beside(__file__, "franka.json")
"""The robot model, a pose, and the layout of a datagram's numbers, each since a server version."""
GET_ROBOT_MODEL = {8: 12, 9: 12, 10: 11}
GUIDING = 3


class DatagramEmulator(Emulator):
    """A controller that sends each state to one client as a datagram."""

    FAULTS = (*COMMON_KINDS, "stranger")
    _udp: UdpPort
    _target: tuple[str, int]
    """Address at which the client listens."""

    @abstractmethod
    def _datagram(self, state: JointState, moment: float) -> bytes:
        """Return the datagram of a state."""

    def send_state(self, state: JointState, moment: float) -> None:
        """Send one datagram, and a stranger's."""
        datagram = self._datagram(state, moment)
        self.emit(self._udp.send, datagram, moment, self._target)
        if self.faults.is_active("stranger", moment):
            position = tuple(q + 0.1 for q in state.position)
            datagram = self._datagram(replace(state, position=position), moment)
            self._stranger.send(datagram, self._target)

    @cached_property
    def _stranger(self) -> UdpPort:
        return UdpPort(self, STRANGER)


class FrankaEmulator(DatagramEmulator):
    """A Panda (versions 3 to 5) or FR3 (6 to 10)."""

    VERSIONS = dict.fromkeys(
        ("5", "3", "4", "6", "7", "8", "9", "10"),
        Version(7, 1000.0),
    )
    FAULTS = (*DatagramEmulator.FAULTS, "version")

    def listen(self, address: str) -> None:
        """Open TCP port 1337."""
        endpoint = parse_endpoint(address, 1337, default_host="127.0.0.1")
        self._target = ("", 0)
        self._tcp = TcpServer(self, (endpoint.host, endpoint.port), self._request)
        self._tcp.on_leave = self._forget
        self.driver_address = f"franka:{self._tcp.address}"
        self._udp = UdpPort(self, (endpoint.host, 0))  # a reader sends it nothing

    def _datagram(self, state: JointState, moment: float) -> bytes:
        return encode_state(int(self.version), self.number, state)

    def _request(self, request: bytes) -> None:
        """Answer one request of the client."""
        if len(request) < 12:
            return
        command, identifier, _ = struct.unpack_from("<III", request)
        if command == 0 and len(request) == 16:
            self._connect(identifier, *struct.unpack_from("<HH", request, 12))
        elif command == GET_ROBOT_MODEL.get(int(self.version)):
            self._reply(command, identifier, b"\0" + FRANKA["model"].encode())

    def _connect(
        self,
        identifier: int,
        version: int,
        port: int,
    ) -> None:
        is_unknown = self.faults.is_active("version", self.moment)
        offered = 99 if is_unknown else int(self.version)
        refused = version != offered
        self._reply(0, identifier, struct.pack("<BH", refused, offered))
        for client in [] if refused else self._tcp.clients:  # none, where it has left
            self.arm.connect()
            self._target = (client.getpeername()[0], port)
            self.streaming = True

    def _reply(
        self,
        command: int,
        identifier: int,
        payload: bytes,
    ) -> None:
        header = struct.pack("<III", command, identifier, 12 + len(payload))
        self._tcp.send(header + payload)

    def _forget(self) -> None:
        self.streaming = False


def encode_state(version: int, number: int, state: JointState) -> bytes:
    """Return the numbered RobotState datagram of a server version, 3 to 10, of an arm at rest."""
    letter = "f" if version == 10 else "d"
    values = {
        "pose": FRANKA["pose"],
        "positions": state.position,
        "torques": state.effort or 7 * (0.0,),
        "zero": (0,),
    }
    message: list[float] = []
    for field in FRANKA["layout"]:
        if version >= field["since"]:
            message += field["times"] * [*values[field["hold"]]]
    errors = bytes(2 * (37 if version < 5 else 41))  # current, and reflex reason
    modes = b"\0\0"  # motion generator, controller
    body = struct.pack(f"<Q{len(message)}{letter}", number, *message)
    return body + modes + errors + struct.pack(f"<B{letter}", GUIDING, 1.0)


MONITORING_WAIT, MONITORING_READY, COMMANDING_ACTIVE = 1, 2, 4
START_OF_CLOCK = 1_700_000_000


class KukaEmulator(DatagramEmulator):
    """An iiwa whose Sunrise application has opened FRI of one version."""

    VERSIONS = dict.fromkeys(
        ("1.15", "1.11", "1.14", "1.16", "2.5", "2.7"),
        Version(7, 200.0),
    )
    FAULTS = (*DatagramEmulator.FAULTS, "version", "commanding")

    def listen(self, address: str) -> None:
        """Bind the controller's UDP port; the session's client is on the same port."""
        endpoint = parse_endpoint(
            address,
            30200,
            options=("client", "multiplier"),
            default_host="127.0.0.2",
        )
        self._target = (endpoint.options.get("client", "127.0.0.1"), endpoint.port)
        self._multiplier = endpoint.options.integer("multiplier", 1)
        self._udp = UdpPort(self, (endpoint.host, endpoint.port), self._reply)
        self.driver_address = f"kuka:{self._udp.address}?bind={self._target[0]}"
        self._replies = 0
        self.streaming = True

    def _datagram(self, state: JointState, moment: float) -> bytes:
        session = MONITORING_READY if self._replies else MONITORING_WAIT
        if self.faults.is_active("commanding", moment):
            session = COMMANDING_ACTIVE
        identifier = 0x245199 if self.faults.is_active("version", moment) else 0x245142
        reflected = max(0, self._replies - 1)
        period = round(1000 / self.arm.rate)
        return encode_message(
            self.version,
            header=(identifier, self.number, reflected),
            connection=(session, 3, period, self._multiplier),
            state=state,
            nanoseconds=self.number * round(1e9 / self.arm.rate),
        )

    def _reply(self, _: bytes) -> None:
        """Count a reply; the client counts its replies from 0."""
        self._replies += 1
        self.arm.connect()


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
    joints = len(state.position)
    zeros = (0.0,) * joints
    q = doubles(state.position)
    # An iiwa's other sign.
    torques = doubles([-torque for torque in state.effort or zeros])
    seconds, remainder = divmod(nanoseconds, 1_000_000_000)
    clock = numbers({1: START_OF_CLOCK + seconds, 2: remainder})
    values = {1: q, 2: torques, 3: q, 4: torques, 5: doubles(zeros), 15: clock}
    if not version.startswith("1."):
        del values[3]
    robot = numbers({1: joints, 2: 0}) + joints * numbers({5: 2})
    override = b"\x61" + struct.pack("<d", 1.0)
    parts = {
        1: numbers(dict(enumerate(header, 1))),
        2: robot + numbers({6: 0, 7: 0}),
        3: b"".join(starmap(nested, values.items())),
        4: numbers(dict(enumerate(connection, 1))),
        5: numbers({10: 0, 11: 0}) + override,
    }
    body = b"".join(starmap(nested, parts.items()))
    return framed(body) if version == "2.7" else body + nested(15, b"")


def doubles(values: Sequence[float]) -> bytes:
    """Return a JointValues message, unpacked as the controller writes it."""
    return b"".join(b"\x09" + struct.pack("<d", value) for value in values)

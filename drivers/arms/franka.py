"""Franka Panda (FER) and FR3: the Franka Control Interface, listened to.

Over TCP this computer and the robot agree on a protocol version, and this computer names a UDP
port, to which the robot then sends its state once a millisecond. Nothing more is ever sent, not
even a datagram. Closing the TCP connection ends the stream. Efforts are ``tau_J``, measured on the
joints' link side; at rest they have the sign of the gravity torque (not proven on a robot here).

Address: ``HOST[:PORT][?version=N]``. The version is negotiated unless it is given.
"""

import socket
import struct
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing

from .. import DriverError, JointState, Reason, ValidatingDriver, clock, match_joints
from ..transport import CONNECT_SECONDS, DatagramSocket, Endpoint, open_tcp, parse_endpoint
from .franka_state import JOINTS, PERIOD, decode_state

PORT = 1337
VERSIONS = range(3, 11)
FIRST_VERSION = 5  # the last of the Panda; any other robot answers with its own
SETTLE_SECONDS = 0.2  # between a refused connection and the next

CONNECT = 0
REQUEST = struct.Struct("<IIIHH")  # command, command id, size, version, UDP port
RESPONSE = struct.Struct("<IIIBH")  # command, command id, size, status, version
SUCCESS, INCOMPATIBLE = 0, 1


class Franka(ValidatingDriver):
    """A Panda or FR3 that streams its state at 1 kHz."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("version",))
        version = endpoint.options.integer("version", FIRST_VERSION)
        if version not in VERSIONS:
            raise endpoint.options.wrong("version", f"from {VERSIONS[0]} to {VERSIONS[-1]}")
        super().__init__(f"the robot at {endpoint}", PERIOD)
        self._joint_names = match_joints(joint_names, JOINTS, "a Franka arm")
        self._tcp, self._udp = _connect(endpoint, version, self._count_rejected)

    def _receive(self, deadline: float) -> JointState:
        asked = clock.now()
        for datagram, _ in self._udp.until(deadline):
            state, self.status = decode_state(datagram)
            return state
        if _is_closed(self._tcp):
            raise DriverError(Reason.UNREACHABLE, f"{self._where} closed the connection")
        hint = "does a firewall here block UDP from it?"
        if self.status:
            hint = f"its last mode: {self.status}. Desk may pause FCI in its programming mode"
        raise self._silence(asked, deadline, more=f"; {hint}")

    def _disconnect(self) -> None:
        self._tcp.close()
        self._udp.close()


def _connect(
    endpoint: Endpoint, version: int, on_stranger: Callable[[], None]
) -> tuple[socket.socket, DatagramSocket]:
    """Open the connection, with the version that the robot speaks if it refuses the given one."""
    session = _try_version(endpoint, version, on_stranger)
    if isinstance(session, int):
        if session not in VERSIONS or session == version or "version" in endpoint.options:
            raise DriverError(
                Reason.PROTOCOL,
                f"the robot at {endpoint} speaks version {session} of FCI and refused {version}; "
                f"versions {VERSIONS[0]} to {VERSIONS[-1]} can be read here, tried with libfranka "
                "0.9 and 0.21. Look for a newer mukca, or read the arm by --driver ros",
            )
        clock.sleep(SETTLE_SECONDS)
        version, session = session, _try_version(endpoint, session, on_stranger)
    if isinstance(session, int):
        raise DriverError(
            Reason.PROTOCOL,
            f"the robot at {endpoint} asked for version {version} of FCI, then refused it",
        )
    return session


def _try_version(
    endpoint: Endpoint, version: int, on_stranger: Callable[[], None]
) -> tuple[socket.socket, DatagramSocket] | int:
    """Ask for one version; return the open sockets, or the robot's own version if it refuses."""
    with ExitStack() as opened:
        tcp = opened.enter_context(_open_tcp(endpoint))
        local, robot = tcp.getsockname()[0], tcp.getpeername()[0]
        udp = opened.enter_context(closing(DatagramSocket((local, 0), robot, on_stranger)))
        try:
            tcp.sendall(REQUEST.pack(CONNECT, 0, REQUEST.size, version, udp.port))
            response = _receive_exactly(tcp, RESPONSE.size)
        except OSError as error:
            did = "ended it" if isinstance(error, ConnectionError) else "did not answer"
            raise DriverError(
                Reason.BUSY,
                f"the robot at {endpoint} took the connection, then {did}. If another program "
                "holds FCI, which serves one at a time, close it; else see what Desk says",
            ) from None
        status, server = _parse_response(response, endpoint)
        if status == INCOMPATIBLE:
            return server
        opened.pop_all()
        return tcp, udp


def _open_tcp(endpoint: Endpoint) -> socket.socket:
    """Connect, and have a robot that vanishes noticed within seconds."""
    tcp = open_tcp(endpoint, "activate FCI in Desk, and unlock the joints")
    tcp.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    # TCP_KEEPALIVE is what macOS calls TCP_KEEPIDLE
    seconds = {"TCP_KEEPIDLE": 1, "TCP_KEEPALIVE": 1, "TCP_KEEPCNT": 3, "TCP_KEEPINTVL": 1}
    for name, value in seconds.items():
        if hasattr(socket, name):
            tcp.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
    return tcp


def _receive_exactly(tcp: socket.socket, count: int) -> bytes:
    deadline = clock.now() + CONNECT_SECONDS
    received = b""
    while len(received) < count:
        if not clock.wait([tcp], max(0.0, deadline - clock.now())):
            raise TimeoutError
        more = tcp.recv(count - len(received))
        if not more:
            raise ConnectionError
        received += more
    return received


def _parse_response(response: bytes, endpoint: Endpoint) -> tuple[int, int]:
    """Return status and server version of a connect response."""
    command, identifier, size, status, server = RESPONSE.unpack(response)
    header = (command, identifier, size)
    if header != (CONNECT, 0, RESPONSE.size) or status not in (SUCCESS, INCOMPATIBLE):
        raise DriverError(
            Reason.PROTOCOL,
            f"what listens at {endpoint} does not speak FCI: it answered {response.hex(' ')}",
        )
    return status, server


def _is_closed(tcp: socket.socket) -> bool:
    """Tell whether the other side has ended the connection."""
    try:
        return bool(clock.wait([tcp], 0)) and not tcp.recv(1, socket.MSG_PEEK)
    except (OSError, ValueError):
        return True

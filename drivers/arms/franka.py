"""Franka Panda (FER) and FR3: the Franka Control Interface, listened to.

Over TCP a version is agreed on, and a UDP port named, to which the robot sends a state each
millisecond; nothing more is ever sent. Efforts are ``tau_J``; at rest they have the sign of the
gravity torque (not proven on a robot here). RobotState datagrams are little-endian::

    bytes  server versions   robots                    numbers   errors
    2085   3                 Panda, system 3.0         float64   37
    2341   4                 Panda, system 4.0         float64   37
    2373   5 to 9            Panda 4.2, FR3 to 5.7     float64   41
    1377   10                FR3 from 5.9              float32   41

Address: ``HOST[:PORT][?version=N]``. The version is negotiated unless it is given.
"""

import math
import struct
from collections.abc import Callable
from contextlib import ExitStack, closing
from itertools import starmap
from typing import Any, cast

from ...errors import read_beside
from .. import (
    DriverError,
    JointState,
    ModelNames,
    Reason,
    ValidatingDriver,
    clock,
    match_joints,
    require_angles,
    require_finite,
)
from ..transport import (
    CONNECT_SECONDS,
    DatagramSocket,
    Endpoint,
    TcpStream,
    cut,
    parse_endpoint,
)

PORT = 1337
VERSIONS = range(3, 11)
FIRST_VERSION = 5  # the last of the Panda; any other robot answers with its own
SETTLE_SECONDS = 0.2  # between a refused connection and the next

CONNECT = 0
REQUEST = struct.Struct("<IIIHH")  # command, command id, size, version, UDP port
RESPONSE = struct.Struct("<IIIBH")  # command, command id, size, status, version
SUCCESS, INCOMPATIBLE = 0, 1

JOINTS = 7
PERIOD = 1e-3  # s
LARGEST_ANGLE = 2 * math.pi  # no joint of these arms turns further

_NAMES = read_beside(__file__, "franka.json")
MODES: list[str] = _NAMES["modes"]
ERRORS: list[str] = _NAMES["errors"]
"""In the order of the flags, as libfranka names them; where there are 37, the last four lack."""


class Franka(ValidatingDriver):
    """A Panda or FR3 that streams its state at 1 kHz."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("version",))
        version = endpoint.options.integer("version", FIRST_VERSION)
        if version not in VERSIONS:
            raise endpoint.options.wrong(
                "version", f"from {VERSIONS[0]} to {VERSIONS[-1]}"
            )
        super().__init__(f"the robot at {endpoint}", PERIOD)
        self._joint_names = match_joints(joint_names, JOINTS, "a Franka arm")
        self._tcp, self._udp = _connect(endpoint, version, self._count_rejected)

    def _receive(self, deadline: float) -> JointState:
        for datagram, _ in self._udp.until(deadline):
            state, self.status = decode_state(datagram)
            return state
        if self._tcp.ended:
            raise Reason.UNREACHABLE(
                f"{self._where} closed the connection: see what Desk says"
            )
        hint = "does a firewall here block UDP from it?"
        if self.status:
            hint = f"its last mode: {self.status}. Desk may pause FCI in its programming mode"
        raise self._silence(deadline, advice=f"; {hint}")

    def _disconnect(self) -> None:
        self._tcp.close()
        self._udp.close()


def _connect(
    endpoint: Endpoint, version: int, on_stranger: Callable[[], None]
) -> tuple[TcpStream, DatagramSocket]:
    """Open the connection, with the version that the robot speaks if it refuses the given one."""
    session = _try_version(endpoint, version, on_stranger)
    if not isinstance(session, int):
        return session
    is_given = "version" in endpoint.options
    if session not in VERSIONS or session == version or is_given:
        raise Reason.PROTOCOL(
            f"the robot at {endpoint} speaks version {session} of FCI and refused {version}; "
            f"versions {VERSIONS[0]} to {VERSIONS[-1]} can be read here, tried with libfranka "
            "0.9 and 0.21. Look for a newer mukca, or read the arm by --driver ros"
        )
    clock.sleep(SETTLE_SECONDS)
    version, session = session, _try_version(endpoint, session, on_stranger)
    if isinstance(session, int):
        raise Reason.PROTOCOL(
            f"the robot at {endpoint} asked for version {version} of FCI, then refused it"
        )
    return session


def _try_version(
    endpoint: Endpoint, version: int, on_stranger: Callable[[], None]
) -> tuple[TcpStream, DatagramSocket] | int:
    """Ask for one version; return the open sockets, or the robot's own version if it refuses."""
    with ExitStack() as opened:
        advice = "activate FCI in Desk, and unlock the joints"
        tcp = opened.enter_context(closing(TcpStream(endpoint, advice)))
        tcp.keep_alive()
        local, robot = tcp.hosts
        udp = opened.enter_context(
            closing(DatagramSocket((local, 0), robot, on_stranger))
        )
        try:
            tcp.send(REQUEST.pack(CONNECT, 0, REQUEST.size, version, udp.port))
            deadline = clock.now() + CONNECT_SECONDS
            response = tcp.take(lambda received: cut(received, RESPONSE.size), deadline)
        except DriverError as error:
            did = "did not answer" if error.reason is Reason.SILENT else "ended it"
            raise Reason.BUSY(
                f"the robot at {endpoint} took the connection, then {did}. If another program "
                "holds FCI, which serves one at a time, close it; else see what Desk says"
            ) from None
        *header, status, server = RESPONSE.unpack(response)
        if header != [CONNECT, 0, RESPONSE.size] or status not in (
            SUCCESS,
            INCOMPATIBLE,
        ):
            raise Reason.PROTOCOL(
                f"what listens at {endpoint} does not speak FCI: it answered {response.hex(' ')}"
            )
        if status == INCOMPATIBLE:
            return server
        opened.pop_all()
        return tcp, udp


def _layout(
    letter: str, torque: int, position: int, errors: int, count: int
) -> struct.Struct:
    """Return message_id, tau_J, q, current and last errors, mode and success rate, by offsets."""
    seven = struct.calcsize(f"<7{letter}")
    return struct.Struct(
        f"<Q{torque - 8}x7{letter}{position - torque - seven}x7{letter}"
        f"{errors - position - seven}x{count}s{count}sB{letter}"
    )


LAYOUTS = {layout.size: layout for layout in starmap(_layout, _NAMES["layouts"])}
"""By the length of a RobotState; offsets [bytes] as in the headers of libfranka-common."""


def decode_state(datagram: bytes) -> tuple[JointState, str]:
    """Return the state in a RobotState datagram, and mode and errors in words."""
    layout = LAYOUTS.get(len(datagram))
    if layout is None:
        raise ValueError(
            f"a datagram of {len(datagram)} bytes is no robot state that is known here "
            f"(they have {', '.join(map(str, LAYOUTS))})"
        )
    fields: tuple[Any, ...] = layout.unpack(datagram)
    torque, position = fields[1:8], fields[8:15]
    current, reflex, mode, rate = cast("tuple[bytes, bytes, int, float]", fields[15:])
    if (
        mode >= len(MODES)
        or (current + reflex).strip(b"\x00\x01")
        or not 0 <= rate <= 1
    ):
        raise ValueError(
            "a robot state with an unknown mode, error flag or success rate"
        )
    require_angles(position, LARGEST_ANGLE, "a robot state")
    require_finite(torque, "a robot state with torques")
    errors = [name for name, flag in zip(ERRORS, current, strict=False) if flag]
    return JointState(fields[0] * PERIOD, position, torque), "; ".join(
        [MODES[mode], *errors]
    )

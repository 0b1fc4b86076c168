"""Franka's controller: FCI of server versions 3 to 10, field by field as libfranka's header.

Proven against libfranka 0.9.2 (version 5) and 0.21.3 (version 10).
"""

import struct

from ...drivers import JointState
from ...drivers.transport import parse_endpoint
from .arm import COMMON_KINDS
from .emulator import Emulator, Version
from .ports import STRANGER, TcpServer, UdpPort

LIMITS = '<limit lower="-2.9" upper="2.9" velocity="2.6" effort="87"/>'
VELOCITY = '<position_based_velocity_limits velocity_offset="1" deceleration_limit="5"/>'
MODEL = (
    '<robot name="fr3">'
    + "".join(f'<link name="link{i}"/>' for i in range(8))
    + "".join(
        f'<joint name="joint{i}" type="revolute"><parent link="link{i - 1}"/>'
        f'<child link="link{i}"/><axis xyz="0 0 1"/>{LIMITS}{VELOCITY}</joint>'
        for i in range(1, 8)
    )
    + "</robot>"
)
GET_ROBOT_MODEL = {8: 12, 9: 12, 10: 11}
GUIDING = 3


class FrankaEmulator(Emulator):
    """A Panda (versions 3 to 5) or FR3 (6 to 10)."""

    VERSIONS = dict.fromkeys(("5", "3", "4", "6", "7", "8", "9", "10"), Version(7, 1000.0))
    FAULTS = (*COMMON_KINDS, "stranger", "version")

    def listen(self, address: str) -> None:
        """Open TCP port 1337."""
        endpoint = parse_endpoint(address, 1337, default_host="127.0.0.1")
        self._target = ("", 0)
        self._tcp = TcpServer(self, (endpoint.host, endpoint.port), self._request)
        self._tcp.on_leave = self._forget
        self._forget()
        self.driver_address = f"franka:{self._tcp.address}"
        self._udp = UdpPort(self, (endpoint.host, 0))  # a reader sends it nothing
        self._stranger = UdpPort(self, STRANGER)

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send one RobotState datagram."""
        datagram = encode_state(int(self.version), number, state)
        self.emit(self._udp.send, datagram, moment, self._target)
        if self.faults.is_active("stranger", moment):
            wrong = JointState(0, tuple(q + 0.1 for q in state.position), state.effort)
            self._stranger.send(encode_state(int(self.version), number, wrong), self._target)

    def _request(self, request: bytes) -> None:
        """Answer one request of the client."""
        if len(request) < 12:
            return
        command, identifier, _ = struct.unpack_from("<III", request)
        if command == 0 and len(request) == 16:
            self._connect(identifier, *struct.unpack_from("<HH", request, 12))
        elif command == GET_ROBOT_MODEL.get(int(self.version)):
            self._reply(command, identifier, b"\0" + MODEL.encode())

    def _connect(self, identifier: int, version: int, port: int) -> None:
        own = 99 if self.faults.is_active("version", self.moment) else int(self.version)
        self._reply(0, identifier, struct.pack("<BH", version != own, own))
        for client in self._tcp.clients if version == own else ():  # it may have left
            self.begin()
            self._target, self.streaming = (client.getpeername()[0], port), True

    def _reply(self, command: int, identifier: int, payload: bytes) -> None:
        header = struct.pack("<III", command, identifier, 12 + len(payload))
        self._tcp.send(header + payload)

    def _forget(self) -> None:
        self.streaming = False


def encode_state(version: int, number: int, state: JointState) -> bytes:
    """Return the numbered RobotState datagram of a server version, 3 to 10, of an arm at rest."""
    letter = "f" if version == 10 else "d"
    zeros: tuple[float, ...] = (0.0,)
    pose = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.3, 0.0, 0.5, 1.0)
    q, tau = state.position, state.effort or 7 * zeros
    numbers: list[float] = []
    numbers += 2 * pose  # O_T_EE, O_T_EE_d
    numbers += (2 if version == 3 else 4) * pose  # F_T_EE, EE_T_K; F_T_NE and NE_T_EE from 4 on
    numbers += (1 + 9 + 3 + 1 + 9 + 3) * zeros  # mass, inertia and centre: end effector, load
    numbers += 4 * zeros  # elbow, elbow_d
    numbers += (*tau, *tau, *7 * zeros)  # tau_J, tau_J_d, dtau_J
    numbers += (*q, *q, *(3 * 7) * zeros)  # q, q_d, dq, dq_d, ddq_d
    numbers += (7 + 6 + 7 + 6) * zeros  # contacts and collisions, joint and Cartesian
    numbers += (7 + 6 + 6 + 6) * zeros  # tau_ext, O_F_ext, K_F_ext, O_dP_EE_d
    numbers += (3 if version >= 5 else 0) * zeros  # O_ddP_O
    numbers += 6 * zeros  # elbow_c and its derivatives
    numbers += (*pose, *12 * zeros)  # O_T_EE_c, O_dP_EE_c, O_ddP_EE_c
    numbers += (*q, *7 * zeros)  # theta, dtheta
    numbers += (36 if version == 10 else 0) * zeros  # accelerometers, top and bottom
    flags = bytes(2 * (37 if version < 5 else 41))  # current errors, reflex reason
    modes = b"\0\0"  # motion generator, controller
    return (
        struct.pack(f"<Q{len(numbers)}{letter}", number, *numbers)
        + modes
        + flags
        + struct.pack(f"<B{letter}", GUIDING, 1.0)
    )

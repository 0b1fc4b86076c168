"""Kinova: Gen2 and JACO actuators over RS-485 or CAN (experimental), Gen3 over Kortex.

The sign of the torques was not proven; answers carry no numbers, so missed states are not counted.
``kortex_api``, a wheel of Kinova's, was tested by a stand-in; ``RefreshFeedback`` commands nothing.

Address: ``serial://PORT?baud=..&parity=..&stopbits=..``, ``can://[INTERFACE/]CHANNEL?tx=..&rx=..``
(ISO-TP), or ``kortex://HOST[:PORT]?user=..&password=..``; all take ``rate=HZ`` and ``effort=-1``.
"""

import importlib
import math
from collections.abc import Callable
from concurrent.futures import TimeoutError as FutureTimeoutError
from contextlib import suppress
from itertools import chain
from typing import Any

from .. import (
    DriverError,
    JointState,
    JointValues,
    ModelNames,
    PolledDriver,
    Reason,
    clock,
    match_joints,
)
from ..transport import Endpoint, open_tcp, parse_endpoint
from .kinova_bus import Answers, KinovaArm, PolledArm, open_can, open_serial

TURN = 360.0  # degrees
KORTEX_PORT = 10000
ONE_MOMENT = (
    0.1  # s: joints that answer within it were measured together, as a hand is slow
)

CLASSES = {
    "TCPTransport": "TCPTransport",
    "RouterClient": "RouterClient",
    "RouterClientSendOptions": "RouterClient",
    "SessionManager": "SessionManager",
    "CreateSessionInfo": "autogen.messages.Session_pb2",
    "BaseCyclicClient": "autogen.client_stubs.BaseCyclicClientRpc",
    "DeviceConfigClient": "autogen.client_stubs.DeviceConfigClientRpc",
}
"""Classes of ``kortex_api`` that are used, and the modules that hold them."""
SESSION_MILLISECONDS = 60_000
CONNECTION_MILLISECONDS = 2_000


class Kinova(PolledDriver):
    """A connection to a Kinova arm, which is asked for its joints again and again."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        super().__init__("the Kinova arm")
        scheme, separator, path = address.partition("://")
        kinds = {"serial": open_serial, "can": open_can, "kortex": Kortex}
        if not separator or scheme not in kinds:
            raise Reason.BAD_ADDRESS(
                f"kinova address {address!r}: expected serial://PORT (Gen2, JACO), can://CHANNEL, "
                "or kortex://HOST (Gen3, Gen3 lite)"
            )
        self._arm: PolledArm | Kortex = kinds[scheme](path)
        with self._closed_on_error():
            self._joint_names = match_joints(
                joint_names, self._arm.joints, "the Kinova arm"
            )
        self.identity = self._arm.identity
        self._last: JointValues = ()  # joint angles [degrees]
        self._fastest = math.inf

    def _receive(self, deadline: float) -> JointState:
        self._await_turn(deadline)
        before = self._arm.rejected
        try:
            (degrees, torques), stamp = self._measure(deadline)
        finally:
            self.rejected += self._arm.rejected - before
        effort = tuple(self._arm.sign * torque for torque in torques)
        # Each is within half a turn of the joint's last one.
        start = (0.0,) * len(degrees) if self._arm.centred else degrees
        pairs = zip(degrees, self._last or start, strict=True)
        self._last = tuple(a - TURN * round((a - last) / TURN) for a, last in pairs)
        return JointState(stamp, tuple(map(math.radians, self._last)), effort)

    def _disconnect(self) -> None:
        self._arm.close()

    def _measure(self, deadline: float) -> tuple[Answers, float]:
        """Ask all joints once; return their answers and the time in the middle [s]."""
        # Joints are asked one after the other. If that takes much longer than the fastest time so
        # far, the computer or the bus was held up, and the arm may have moved: all are asked again.
        while True:
            start = clock.now()
            self._next_poll = start + 1 / self._arm.rate
            answers = self._arm.measure(deadline)
            end = clock.now()
            if end - start <= max(ONE_MOMENT, 2 * self._fastest):
                self._fastest = min(self._fastest, end - start)
                return answers, (start + end) / 2
            self._count_rejected()
            self._fastest *= (
                1.05  # so that a bus that became slower is accepted after a while
            )
            if end >= deadline:
                raise Reason.SILENT(f"the joints take {end - start:.2g} s to answer")


class Kortex(KinovaArm):
    """A session with a Gen3 arm."""

    centred = True

    def __init__(self, path: str) -> None:
        endpoint = parse_endpoint(
            path, KORTEX_PORT, ("user", "password", "rate", "effort")
        )
        self.rate = endpoint.options.positive("rate", 100)
        self.sign = endpoint.options.sign("effort")
        self._where = str(endpoint)
        self._ends: list[Callable[[], object]] = []
        self._open(endpoint)
        self.joints = len(self.measure(clock.now() + 2)[0])
        self.identity = self._serial_number()

    def measure(self, deadline: float) -> Answers:
        """Ask for the arm's feedback, until its values are finite."""
        while True:
            answers = self._refresh(max(1e-3, deadline - clock.now()))
            if all(map(math.isfinite, chain(*answers))):
                return answers
            self.rejected += 1
            if clock.now() >= deadline:
                raise Reason.SILENT(
                    f"the arm at {self._where} answers without numbers: is it still starting?"
                )

    def _refresh(self, timeout: float) -> Answers:
        self._options.timeout_ms = math.ceil(1000 * timeout)
        try:
            feedback = self._cyclic.RefreshFeedback(options=self._options)
        except (TimeoutError, FutureTimeoutError):
            raise Reason.SILENT(
                f"the arm at {self._where} does not answer: is it switched on?"
            ) from None
        except Exception as error:
            raise self._failed(error) from error
        actuators = feedback.actuators
        angles = [float(actuator.position) for actuator in actuators]
        torques = [float(actuator.torque) for actuator in actuators]
        return angles, torques

    def _serial_number(self) -> str:
        """Return the base's serial number, in words; nothing where it tells none."""
        self._options.timeout_ms = CONNECTION_MILLISECONDS
        try:
            number = self._config.GetSerialNumber(options=self._options).serial_number
        except Exception:
            return ""
        return f"serial number {number}"

    def close(self) -> None:
        """End the session and the connection; safe to call twice."""
        while self._ends:
            with suppress(Exception):  # the arm is gone, or forgot the session
                self._ends.pop()()

    def _open(self, endpoint: Endpoint) -> None:
        """Connect, log in, and make the client that asks."""
        try:
            kortex: dict[str, Any] = {
                name: getattr(importlib.import_module(f"kortex_api.{module}"), name)
                for name, module in CLASSES.items()
            }
        except ImportError as error:
            raise Reason.MISSING_PACKAGE(
                "kinova over Kortex needs kortex_api, which is not on PyPI: install the wheel that "
                f"the readme of github.com/Kinovarobotics/kortex names ({error})"
            ) from None
        self._options = kortex["RouterClientSendOptions"]()
        open_tcp(
            endpoint, "is this the arm's address?"
        ).close()  # the transport waits for ever
        try:
            transport = kortex["TCPTransport"]()
            self._ends.append(transport.disconnect)
            transport.connect(endpoint.host, endpoint.port)
            # bool takes the transport's errors, which every call raises as well
            router = kortex["RouterClient"](transport, bool)
            login = kortex["CreateSessionInfo"]()
            login.username = endpoint.options.get("user", "admin")
            login.password = endpoint.options.get("password", "admin")
            login.session_inactivity_timeout = SESSION_MILLISECONDS
            login.connection_inactivity_timeout = CONNECTION_MILLISECONDS
            session = kortex["SessionManager"](router)
            self._ends.append(session.CloseSession)
            session.CreateSession(login)
            self._cyclic = kortex["BaseCyclicClient"](router)
            self._config = kortex["DeviceConfigClient"](router)
        except Exception as error:
            self.close()
            raise self._failed(error) from error

    def _failed(self, error: Exception) -> DriverError:
        self.close()
        return Reason.UNREACHABLE(f"the Kinova arm at {self._where}: {error}")

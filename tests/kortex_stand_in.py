"""A stand-in for Kinova's kortex_api, which cannot be installed from PyPI."""

import math
import socket
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any

TORQUES = (1.0, -12.0, 0.5, 7.0, 0.2, 2.0, 0.1)


@dataclass
class Arm:
    """What the stand-in's arm does, and what was asked of it."""

    address: str = ""
    calls: list[str] = field(default_factory=list)
    login: Any = None
    serial_number: str = "GS1904"
    failure: Exception | None = None
    """Raised by each feedback."""
    degrees: list[float] | None = None
    """Positions to tell; by default each joint sways around its own, near 350 degrees, at a rate of
    its own: so no position comes twice, and what was told can be told apart."""
    sent: list[list[float]] = field(default_factory=list)
    """Positions told so far [degrees]."""

    def feedback(self):
        degrees = self.degrees or [_sway(joint, time.monotonic()) for joint in range(7)]
        self.sent.append(degrees)
        actuators = [
            SimpleNamespace(position=angle, torque=torque)
            for angle, torque in zip(degrees, TORQUES, strict=False)
        ]
        return SimpleNamespace(actuators=actuators)


def _sway(joint, now):
    return (350 + joint + 5 * math.sin((1 + joint / 10) * now)) % 360


@contextmanager
def kortex_arm():
    """Make `import kortex_api` find the stand-in, and a port that its arm listens at."""
    arm = Arm()
    modules = stand_in(arm)
    server = socket.create_server(("127.0.0.1", 0))
    arm.address = f"kortex://127.0.0.1:{server.getsockname()[1]}"
    sys.modules.update(modules)
    try:
        yield arm
    finally:
        for name in modules:
            del sys.modules[name]
        server.close()


def stand_in(arm):
    """Return the package's modules, each call of which is noted."""

    class TCPTransport:
        def connect(self, host, port):
            arm.calls.append("connect")

        def disconnect(self):
            arm.calls.append("disconnect")

    class RouterClient:
        def __init__(self, transport, callback):
            assert isinstance(transport, TCPTransport)
            assert callable(callback)

    class RouterClientSendOptions:
        timeout_ms = 10000

    class CreateSessionInfo:
        def __init__(self):
            arm.login = self

    class SessionManager:
        def __init__(self, router):
            assert isinstance(router, RouterClient)

        def CreateSession(self, info):
            arm.calls.append("CreateSession")

        def CloseSession(self):
            arm.calls.append("CloseSession")

    class BaseCyclicClient:
        def __init__(self, router):
            assert isinstance(router, RouterClient)

        def RefreshFeedback(self, deviceId=0, options=None):
            arm.calls.append("RefreshFeedback")
            assert options.timeout_ms >= 1
            if arm.failure:
                raise arm.failure
            return arm.feedback()

    class DeviceConfigClient(BaseCyclicClient):
        def GetSerialNumber(self, deviceId=0, options=None):
            arm.calls.append("GetSerialNumber")
            if not arm.serial_number:
                raise RuntimeError("no such service")
            return SimpleNamespace(serial_number=arm.serial_number)

    parts = {
        "TCPTransport": [TCPTransport],
        "RouterClient": [RouterClient, RouterClientSendOptions],
        "SessionManager": [SessionManager],
        "autogen.messages.Session_pb2": [CreateSessionInfo],
        "autogen.client_stubs.BaseCyclicClientRpc": [BaseCyclicClient],
        "autogen.client_stubs.DeviceConfigClientRpc": [DeviceConfigClient],
    }
    packages = ("", ".autogen", ".autogen.messages", ".autogen.client_stubs")
    modules = {f"kortex_api{name}": ModuleType(name) for name in packages}
    for name, content in parts.items():
        modules[f"kortex_api.{name}"] = module = ModuleType(name)
        vars(module).update({one.__name__: one for one in content})
    return modules

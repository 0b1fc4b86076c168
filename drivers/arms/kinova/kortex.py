"""Kinova Gen3 and Gen3 lite: the feedback of Kortex, through Kinova's own ``kortex_api``.

That package is not on PyPI; Kinova gives a wheel. What is called here is its transport, router,
session and ``BaseCyclicClient.RefreshFeedback``, which asks and commands nothing. It was tested
against a stand-in for the package, not against the package or an arm.
"""

import importlib
import math
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any

from ... import DriverError, Reason, clock
from ...transport import Endpoint, open_tcp, parse_endpoint
from .kinova import KinovaArm, Measurement

PORT = 10000
SESSION_MILLISECONDS = 60_000
CONNECTION_MILLISECONDS = 2_000
HOW_TO_GET_IT = (
    "kinova over Kortex needs kortex_api, which is not on PyPI: install the wheel that the readme "
    "of github.com/Kinovarobotics/kortex names"
)


class Kortex(KinovaArm):
    """A session with a Gen3 arm."""

    centred = True

    def __init__(self, rest: str) -> None:
        endpoint = parse_endpoint(rest, PORT, ("user", "password", "rate", "effort"))
        self.rate = endpoint.options.positive("rate", 100)
        self.sign = endpoint.options.sign("effort")
        self._where = str(endpoint)
        self._transport: Any = None
        self._session: Any = None
        self._open(endpoint)
        self.joints = len(self.measure(clock.now() + 2).degrees)

    def measure(self, deadline: float) -> Measurement:
        """Ask for the arm's feedback, until its values are finite."""
        while True:
            measurement = self._refresh(max(1e-3, deadline - clock.now()))
            if all(map(math.isfinite, measurement.degrees + measurement.torques)):
                return measurement
            self.rejected += 1
            if clock.now() >= deadline:
                raise DriverError(Reason.SILENT, f"the arm at {self._where} sends no numbers")

    def _refresh(self, timeout: float) -> Measurement:
        self._options.timeout_ms = math.ceil(1000 * timeout)
        try:
            feedback = self._cyclic.RefreshFeedback(options=self._options)
        except (TimeoutError, FutureTimeoutError):
            raise DriverError(Reason.SILENT, f"the arm at {self._where} does not answer") from None
        except Exception as error:
            raise self._failed(error) from error
        actuators = feedback.actuators
        return Measurement(
            tuple(float(actuator.position) for actuator in actuators),
            tuple(float(actuator.torque) for actuator in actuators),
        )

    def close(self) -> None:
        """End the session and the connection; safe to call twice."""
        session, self._session = self._session, None
        transport, self._transport = self._transport, None
        for end in (session and session.CloseSession, transport and transport.disconnect):
            try:
                if end:
                    end()
            except Exception:  # noqa: S110 - the arm is gone, or forgot the session
                pass

    def _open(self, endpoint: Endpoint) -> None:
        """Connect, log in, and make the client that asks."""
        kortex = _modules()
        self._options = kortex["RouterClient"].RouterClientSendOptions()
        open_tcp(endpoint, "is this the arm's address?").close()  # the transport waits for ever
        try:
            self._transport = kortex["TCPTransport"].TCPTransport()
            self._transport.connect(endpoint.host, endpoint.port)
            # bool takes the transport's errors, which every call raises as well
            router = kortex["RouterClient"].RouterClient(self._transport, bool)
            login = kortex["autogen.messages.Session_pb2"].CreateSessionInfo()
            login.username = endpoint.options.get("user", "admin")
            login.password = endpoint.options.get("password", "admin")
            login.session_inactivity_timeout = SESSION_MILLISECONDS
            login.connection_inactivity_timeout = CONNECTION_MILLISECONDS
            self._session = kortex["SessionManager"].SessionManager(router)
            self._session.CreateSession(login)
            client = kortex["autogen.client_stubs.BaseCyclicClientRpc"].BaseCyclicClient
            self._cyclic = client(router)
        except Exception as error:
            self.close()
            raise self._failed(error) from error

    def _failed(self, error: Exception) -> DriverError:
        self.close()
        return DriverError(Reason.UNREACHABLE, f"the Kinova arm at {self._where}: {error}")


def _modules() -> dict[str, Any]:
    """Import the parts of kortex_api that are used."""
    names = (
        "TCPTransport",
        "RouterClient",
        "SessionManager",
        "autogen.messages.Session_pb2",
        "autogen.client_stubs.BaseCyclicClientRpc",
    )
    try:
        return {name: importlib.import_module(f"kortex_api.{name}") for name in names}
    except ImportError as error:
        raise DriverError(Reason.MISSING_PACKAGE, f"{HOW_TO_GET_IT} ({error})") from None

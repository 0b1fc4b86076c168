"""Carries Kinova's messages of 20 bytes over a serial line, or over a CAN bus by ISO-TP."""

import termios
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

import serial

from . import clock
from .driver import DriverError, Reason
from .kinova_actuator import MESSAGE_BYTES

if TYPE_CHECKING:
    import can

__all__ = ["IsoTpLink", "Link", "SerialLink"]


class Link(Protocol):
    """Carries messages of 20 bytes to and fro."""

    def send(self, message: bytes) -> None:
        """Send a message."""
        ...

    def receive(self, wait: float) -> bytes:
        """Return the next message, or the part of it that came within the wait [s]."""
        ...

    def flush(self) -> None:
        """Throw away what has come in."""
        ...

    def close(self) -> None:
        """Free the line; safe to call twice."""
        ...


class SerialLink:
    """A serial line, opened not to block."""

    def __init__(self, port: serial.Serial) -> None:
        self._port = port

    def send(self, message: bytes) -> None:
        """Send a message."""
        with self._translated():
            self._port.write(message)

    def receive(self, wait: float) -> bytes:
        """Return 20 bytes, or as many as came within the wait [s]."""
        deadline = clock.now() + wait
        received = b""
        with self._translated():
            while len(received) < MESSAGE_BYTES:
                left = max(0.0, deadline - clock.now())
                if not clock.wait([self._port], left):
                    break
                received += self._port.read(MESSAGE_BYTES - len(received))
        return received

    def flush(self) -> None:
        """Throw away what has come in."""
        with self._translated():
            self._port.reset_input_buffer()

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    @contextmanager
    def _translated(self) -> Generator[None, None, None]:
        """Turn the errors of a lost line into the driver's own."""
        try:
            yield
        except (OSError, TypeError, ValueError, termios.error) as error:
            raise DriverError(
                Reason.UNREACHABLE, f"serial port {self._port.port} is lost: {error}"
            ) from None


class IsoTpLink:
    """An ISO-TP connection on a CAN bus."""

    def __init__(self, bus: "can.BusABC", transmit: int, receive: int) -> None:
        import isotp

        self._bus = bus
        address = isotp.Address(isotp.AddressingMode.Normal_11bits, txid=transmit, rxid=receive)
        self._stack: Any = isotp.CanStack(bus, address=address)
        self._stack.start()
        self._open = True

    def send(self, message: bytes) -> None:
        """Send a message; the transfer goes on by itself."""
        self._stack.send(message)

    def receive(self, wait: float) -> bytes:
        """Return the next message, or nothing."""
        return bytes(self._stack.recv(block=True, timeout=wait) or b"")

    def flush(self) -> None:
        """Throw away what has come in."""
        while self._stack.available():
            self._stack.recv()

    def close(self) -> None:
        """Leave the bus."""
        if self._open:
            self._open = False
            self._stack.stop()
            self._bus.shutdown()

"""Carries Kinova's messages of 20 bytes over a serial line, or over a CAN bus by ISO-TP."""

from typing import TYPE_CHECKING, Any, Protocol

from . import clock
from .kinova_actuator import MESSAGE_BYTES
from .serial_line import SerialLine

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
    """A serial line."""

    def __init__(self, line: SerialLine) -> None:
        self._line = line
        self.send, self.flush, self.close = line.write, line.flush, line.close

    def receive(self, wait: float) -> bytes:
        """Return 20 bytes, or as many as came within the wait [s]."""
        deadline = clock.now() + wait
        received = b""
        while len(received) < MESSAGE_BYTES:
            came = self._line.read(MESSAGE_BYTES - len(received), deadline - clock.now())
            if not came:
                break
            received += came
        return received


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

"""Carries Kinova's messages of 20 bytes over a serial line, or over a CAN bus by ISO-TP."""

from typing import TYPE_CHECKING, Any, Protocol

from ... import DriverError, Reason, clock
from ...transport import SerialLine
from .actuator_messages import MESSAGE_BYTES

if TYPE_CHECKING:
    import can
    import isotp


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
    """An ISO-TP connection on a CAN bus; it goes on while a message is sent or waited for."""

    def __init__(self, bus: "can.BusABC", transmit: int, receive: int) -> None:
        import isotp

        self._bus = bus
        address = isotp.Address(isotp.AddressingMode.Normal_11bits, txid=transmit, rxid=receive)
        self._transfer: Any = isotp.TransportLayerLogic(self._next_frame, self._send_frame, address)
        self._until = 0.0

    def send(self, message: bytes) -> None:
        """Send a message: its first frame now, the others while its answer is waited for."""
        self._transfer.stop_sending()  # an earlier one that nobody took
        self._transfer.clear_tx_queue()
        self._transfer.send(message)
        self._go_on(0.0)

    def receive(self, wait: float) -> bytes:
        """Return the next message, or nothing."""
        deadline = clock.now() + wait
        while not self._transfer.available() and (left := deadline - clock.now()) > 0:
            pause = self._transfer.next_cf_delay()  # as the other side asked for
            self._go_on(left if pause is None else min(left, pause))
        return bytes(self._transfer.recv() or b"")

    def flush(self) -> None:
        """Throw away what has come in."""
        self._go_on(0.0)
        while self._transfer.available():
            self._transfer.clear_rx_queue()
            self._go_on(0.0)

    def close(self) -> None:
        """Leave the bus; safe to call twice."""
        self._bus.shutdown()

    def _go_on(self, wait: float) -> None:
        """Take and send frames until a message is there; wait for one no longer than this [s]."""
        import can

        self._until = clock.now() + wait
        try:
            self._transfer.process()
        except (can.CanError, OSError, ValueError) as error:
            raise DriverError(Reason.UNREACHABLE, f"the CAN bus is lost: {error}") from None

    def _next_frame(self, _: float) -> "isotp.CanMessage | None":
        import isotp

        if self._transfer.available():
            return None
        frame = self._bus.recv(max(0.0, self._until - clock.now()))
        if frame is None or frame.is_error_frame or frame.is_remote_frame:
            return None
        return isotp.CanMessage(frame.arbitration_id, data=bytes(frame.data))

    def _send_frame(self, frame: "isotp.CanMessage") -> None:
        import can

        self._bus.send(
            can.Message(arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False)
        )

"""Kinova's actuators on a bus: polled one after the other, over a serial line or ISO-TP.

Experimental, known from a driver that wrote these messages to a USB bridge. A message has 20 bytes,
little-endian, no checksum: i16 command | u8 source | u8 destination | 16 bytes of data. Only
GET_ACTUALPOSITION is ever sent; other commands move the arm or rewrite its zeros.
"""

import logging
import math
import struct
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import serial

from .. import DriverError, Reason, clock
from ..transport import (
    CanBus,
    FreshAnswers,
    Options,
    SerialLine,
    parse_can_address,
    parse_options,
)

if TYPE_CHECKING:
    import isotp

GET_ACTUALPOSITION = 0x01
SEND_ACTUALPOSITION = 0x02
HOST = 0x00
FIRST_ACTUATOR = 0x10  # at the base; the others follow
MESSAGE = struct.Struct("<hBB16s")
VALUES = struct.Struct("<4f")
LARGEST_DEGREES = 100 * 360.0  # some of these joints turn without end
ARM_OPTIONS = ("joints", "rate", "effort")
LINE_OPTIONS = ("baud", "parity", "stopbits", "databits")
PARITIES = {name.lower(): letter for letter, name in serial.PARITY_NAMES.items()}
FIRST_ANSWER_SECONDS = 1.0
ANSWER_SECONDS = 0.1  # then the actuator is asked again


Answers = tuple[Sequence[float], Sequence[float]]
"""Angles [degrees] and torques [N m] of all joints, from base to flange, by the arm's own sign."""


class KinovaArm:
    """A connection that is asked for the joints again and again."""

    joints: int
    """Number of the arm's joints."""
    sign: int
    """1, or -1 where the torques have the opposite sign of what a state needs."""
    rate: float
    """Rate at which to ask [Hz]."""
    centred: bool = False
    """True where the first angle of each joint is brought between -180 and 180 degrees."""
    rejected: int = 0
    """Number of answers that could not be used."""
    identity: str = ""
    """Serial number in words; empty where the protocol tells none."""


def decode_reply(message: bytes, actuator: int) -> tuple[float, float]:
    """Return an actuator's angle [degrees] and torque, presumably in N m."""
    if len(message) != MESSAGE.size:
        raise ValueError(
            f"a message of {len(message)} bytes where {MESSAGE.size} are expected"
        )
    command, source, destination, data = MESSAGE.unpack(message)
    if (command, source, destination) != (SEND_ACTUALPOSITION, actuator, HOST):
        raise ValueError(f"a message that is no position of actuator 0x{actuator:02x}")
    current, degrees, speed, torque = VALUES.unpack(data)
    if not all(map(math.isfinite, (current, speed, torque))) or not (
        abs(degrees) <= LARGEST_DEGREES
    ):
        raise ValueError(f"impossible values from actuator 0x{actuator:02x}")
    return degrees, torque


class SerialLink:
    """Messages of 20 bytes on a serial line."""

    def __init__(self, line: SerialLine) -> None:
        self._line = line
        self.send, self.discard, self.close = line.write, line.discard, line.close

    def receive(self, wait: float) -> bytes:
        """Return 20 bytes, or as many as came within the wait [s]."""
        deadline = clock.now() + wait
        received = b""
        while len(received) < MESSAGE.size:
            came = self._line.read(MESSAGE.size - len(received), deadline - clock.now())
            if not came:
                break
            received += came
        return received


class IsoTpLink:
    """Messages by ISO-TP on a CAN bus; a transfer goes on while a message is sent or waited for."""

    def __init__(self, bus: CanBus, transmit: int, receive: int) -> None:
        import isotp

        # Else its warnings are on the screen.
        logging.getLogger("isotp").addHandler(logging.NullHandler())
        self._bus = bus
        self.close = bus.close
        address = isotp.Address(
            isotp.AddressingMode.Normal_11bits, txid=transmit, rxid=receive
        )
        self._transfer: Any = isotp.TransportLayerLogic(
            self._next_frame,
            lambda frame: bus.send(frame.arbitration_id, bytes(frame.data)),
            address,
        )
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
        while (
            not self._transfer.available() and (remainder := deadline - clock.now()) > 0
        ):
            pause = self._transfer.next_cf_delay()  # as the other side asked for
            self._go_on(remainder if pause is None else min(remainder, pause))
        return bytes(self._transfer.recv() or b"")

    def discard(self, wait: float) -> bool:
        """Throw away a message that has come, or comes within the wait [s]; return if any did."""
        self._go_on(0.0)
        return bool(self.receive(wait))

    def _go_on(self, wait: float) -> None:
        """Take and send frames until a message is there; wait for one no longer than this [s]."""
        self._until = clock.now() + wait
        self._transfer.process()

    def _next_frame(self, _: float) -> "isotp.CanMessage | None":
        import isotp

        if self._transfer.available():
            return None
        frame = self._bus.receive(self._until)
        if frame is None:
            return None
        return isotp.CanMessage(frame.arbitration_id, data=bytes(frame.data))


class PolledArm(KinovaArm):
    """Actuators that answer one after the other; ``where`` is the link as messages name it."""

    def __init__(
        self, link: SerialLink | IsoTpLink, where: str, options: Options
    ) -> None:
        self._link, self._where = link, where
        self._fresh = FreshAnswers(link.discard)
        try:
            self.joints = options.integer("joints", 6)
            self.rate, self.sign = options.positive("rate", 100), options.sign("effort")
            if self.joints not in range(1, 8):
                raise options.wrong("joints", "a number from 1 to 7")
            self.measure(clock.now() + FIRST_ANSWER_SECONDS)
        except DriverError as error:
            self.close()
            if error.reason is Reason.BAD_ADDRESS:
                raise
            advice = "is the arm on, and are the settings right?"
            raise Reason.UNREACHABLE(f"{error}: {advice}") from None
        except BaseException:
            self.close()
            raise

    def measure(self, deadline: float) -> Answers:
        """Return the answers of all actuators; SILENT where one gives none by the deadline [s]."""
        replies: list[tuple[float, float]] = []
        for actuator in range(FIRST_ACTUATOR, FIRST_ACTUATOR + self.joints):
            try:
                replies.append(
                    self._fresh.ask(partial(self._ask, actuator, deadline), deadline)
                )
            except ValueError as error:
                raise Reason.SILENT(str(error)) from None
        degrees, torques = zip(*replies, strict=True)
        return degrees, torques

    def close(self) -> None:
        """Free the line."""
        self._link.close()

    def _ask(self, actuator: int, deadline: float) -> tuple[float, float]:
        """Return an actuator's answer; other messages are counted."""
        self._link.send(
            MESSAGE.pack(GET_ACTUALPOSITION, HOST, actuator, bytes(VALUES.size))
        )
        until = min(deadline, clock.now() + ANSWER_SECONDS)
        while message := self._link.receive(clock.left(until)):
            try:
                return decode_reply(message, actuator)
            except ValueError:
                self.rejected += 1
        raise ValueError(f"actuator 0x{actuator:02x} on {self._where} does not answer")


def open_serial(path: str) -> PolledArm:
    """Open ``PORT?baud=..&parity=..&stopbits=..&databits=..``."""
    port, _, query = path.partition("?")
    options = parse_options(query, (*ARM_OPTIONS, *LINE_OPTIONS))
    parity = options.setdefault("parity", "even")
    if parity not in PARITIES:
        raise options.wrong("parity", f"one of {', '.join(PARITIES)}")
    if not port:
        raise Reason.BAD_ADDRESS("serial:// needs a port, as in serial:///dev/ttyUSB0")
    line = SerialLine(
        port,
        options.integer("baud", 115200),
        bytesize=options.integer("databits", 8),
        parity=PARITIES[parity],
        stopbits=options.positive("stopbits", 2),
    )
    return PolledArm(SerialLink(line), port, options)


def open_can(path: str) -> PolledArm:
    """Open ``[INTERFACE/]CHANNEL?tx=..&rx=..``, the identifiers of the gateway."""
    address = parse_can_address(path, (*ARM_OPTIONS, "tx", "rx"))
    transmit = address.options.integer("tx", 0x700)
    receive = address.options.integer("rx", 0x701)
    bus = CanBus(address, (receive,))
    try:
        link = IsoTpLink(bus, transmit, receive)
    except ImportError:
        bus.close()
        raise Reason.MISSING_PACKAGE(
            "kinova over CAN needs can-isotp: pip install 'mukca[isotp]'"
        ) from None
    except ValueError as error:
        bus.close()
        raise Reason.BAD_ADDRESS(f"can://{path}: {error}") from None
    return PolledArm(link, str(address), address.options)

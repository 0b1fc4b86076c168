"""CAN buses by name: ``[INTERFACE/]CHANNEL[?bitrate=..&port=..&hop_limit=..]``.

INTERFACE is one of python-can's (socketcan where none is given), CHANNEL what it calls the bus:
``can0``, ``slcan//dev/ttyACM0?bitrate=1000000``, ``udp_multicast/239.74.163.2?port=43113``.
"""

from dataclasses import dataclass
from typing import Any

import can

from .. import Reason, clock
from .address import Options, lost, parse_options

BUS_OPTIONS = ("bitrate", "port", "hop_limit")
ALL = range(1 << 11)
POLL_SECONDS = 1e-3  # of a bus that has no descriptor to wait on


@dataclass(frozen=True)
class CanAddress:
    """Interface and channel of a CAN bus, and options."""

    interface: str
    channel: str
    options: Options

    def __str__(self) -> str:
        return f"{self.interface}/{self.channel}"


def parse_can_address(address: str, options: tuple[str, ...] = ()) -> CanAddress:
    """Return interface, channel and options, the bus' own and those named; or raise BAD_ADDRESS."""
    name, _, query = address.partition("?")
    interface, slash, channel = (name or "can0").partition("/")
    if not slash:
        interface, channel = "socketcan", interface
    if not interface or not channel:
        raise Reason.BAD_ADDRESS(
            f"address {address!r}: expected [INTERFACE/]CHANNEL, as in can0 or slcan//dev/ttyACM0"
        )
    return CanAddress(
        interface, channel, parse_options(query, (*BUS_OPTIONS, *options))
    )


class CanBus:
    """A CAN bus whose errors are the driver's own; the identifiers are those to receive."""

    def __init__(self, address: CanAddress, identifiers: tuple[int, ...] = ()) -> None:
        self._address, self._identifiers = address, identifiers
        self._bus = open_bus(address, identifiers)
        try:
            self._watched = [self._bus.fileno()]
        except NotImplementedError:
            self._watched = []

    def send(self, identifier: int, data: bytes) -> None:
        """Send a frame."""
        with lost(f"CAN bus {self._address}", can.CanError, ValueError):
            self._bus.send(
                can.Message(arbitration_id=identifier, data=data, is_extended_id=False)
            )

    def receive(self, deadline: float) -> can.Message | None:
        """Return the next frame with a wanted 11-bit identifier and data; None if time is up."""
        with lost(f"CAN bus {self._address}", can.CanError, ValueError):
            while True:
                # python-can would wait by the wall's time, which is set.
                frame = self._bus.recv(0)
                if frame is None:
                    remainder = deadline - clock.now()
                    if remainder <= 0:
                        return None
                    pause = remainder if self._watched else min(remainder, POLL_SECONDS)
                    clock.wait(self._watched, pause)
                    continue
                kinds = (
                    frame.is_extended_id,
                    frame.is_error_frame,
                    frame.is_remote_frame,
                )
                if not any(kinds) and frame.arbitration_id in (
                    self._identifiers or ALL
                ):
                    return frame

    def discard(self, wait: float) -> bool:
        """Throw away a frame that has come, or comes within the wait [s]; return if one did."""
        return self.receive(clock.now() + wait) is not None

    def close(self) -> None:
        """Leave the bus; safe to call twice."""
        self._bus.shutdown()


def open_bus(address: CanAddress, identifiers: tuple[int, ...] = ()) -> can.BusABC:
    """Open a bus of python-can's; arguments and errors as of :class:`CanBus`."""
    if address.interface not in can.VALID_INTERFACES:
        interfaces = ", ".join(sorted(can.VALID_INTERFACES))
        raise Reason.BAD_ADDRESS(
            f"no CAN interface is called {address.interface!r}; one of: {interfaces}"
        )
    settings: dict[str, Any] = {
        name: address.options.integer(name, 0)
        for name in BUS_OPTIONS
        if name in address.options
    }
    filters = [
        can.typechecking.CanFilter(can_id=identifier, can_mask=0x7FF, extended=False)
        for identifier in identifiers
        if address.interface
        == "socketcan"  # where the kernel filters; others drop one at a wait
    ]
    try:
        return can.Bus(
            interface=address.interface,
            channel=address.channel,
            can_filters=filters or None,
            **settings,
        )
    except (ImportError, can.CanInterfaceNotImplementedError, RuntimeError) as error:
        raise Reason.MISSING_PACKAGE(
            f"CAN bus {address} needs a package: {error}"
        ) from None
    except (can.CanError, OSError, ValueError, TypeError) as error:
        raise Reason.UNREACHABLE(
            f"CAN bus {address} cannot be opened: {error}; is the adapter plugged in, and the "
            "bus up (ip link set can0 up type can bitrate 1000000)?"
        ) from None

"""CAN buses by name: ``[INTERFACE/]CHANNEL[?bitrate=..&port=..&hop_limit=..]``.

INTERFACE is one of python-can's (socketcan where none is given), CHANNEL what it calls the bus:
``can0``, ``slcan//dev/ttyACM0?bitrate=1000000``, ``udp_multicast/239.74.163.2?port=43113``.
"""

from dataclasses import dataclass
from typing import Any

import can

from .. import DriverError, Reason
from .address import Options, parse_options

BUS_OPTIONS = ("bitrate", "port", "hop_limit")


@dataclass(frozen=True)
class CanAddress:
    """A CAN bus, and the options that stand behind the question mark."""

    interface: str
    channel: str
    options: Options

    def __str__(self) -> str:
        return f"{self.interface}/{self.channel}"


def parse_can_address(
    address: str, options: tuple[str, ...] = (), default: str = "can0"
) -> CanAddress:
    """Return the bus that an address names.

    Args:
        address: ``[INTERFACE/]CHANNEL[?option=value&...]``.
        options: Names of the options that are understood beside those of the bus.
        default: The bus where the address names none.

    Raises:
        DriverError: BAD_ADDRESS.
    """
    name, _, query = address.partition("?")
    interface, slash, channel = (name or default).partition("/")
    if not slash:
        interface, channel = "socketcan", interface
    if not interface or not channel:
        raise DriverError(
            Reason.BAD_ADDRESS,
            f"address {address!r}: expected [INTERFACE/]CHANNEL, as in can0 or slcan//dev/ttyACM0",
        )
    return CanAddress(interface, channel, parse_options(query, (*BUS_OPTIONS, *options)))


def open_bus(address: CanAddress, identifiers: tuple[int, ...] = ()) -> can.BusABC:
    """Open a bus.

    Args:
        address: Which one.
        identifiers: The identifiers to receive; all where none is given.

    Raises:
        DriverError: No such interface, a package is missing, or the bus cannot be opened.
    """
    if address.interface not in can.VALID_INTERFACES:
        known = ", ".join(sorted(can.VALID_INTERFACES))
        raise DriverError(
            Reason.BAD_ADDRESS, f"no CAN interface is called {address.interface!r}; one of: {known}"
        )
    settings: dict[str, Any] = {
        name: address.options.integer(name, 0) for name in BUS_OPTIONS if name in address.options
    }
    filters = [
        can.typechecking.CanFilter(can_id=identifier, can_mask=0x7FF, extended=False)
        for identifier in identifiers
    ]
    try:
        return can.Bus(
            interface=address.interface,
            channel=address.channel,
            can_filters=filters or None,
            **settings,
        )
    except (ImportError, can.CanInterfaceNotImplementedError, RuntimeError) as error:
        raise DriverError(
            Reason.MISSING_PACKAGE, f"CAN bus {address} needs a package: {error}"
        ) from None
    except (can.CanError, OSError, ValueError, TypeError) as error:
        raise DriverError(
            Reason.UNREACHABLE,
            f"CAN bus {address} cannot be opened: {error}; is the adapter plugged in, and the "
            "bus up (ip link set can0 up type can bitrate 1000000)?",
        ) from None

"""Addresses as users write them: ``HOST[:PORT][?option=value&...]``, and what they stand for."""

import socket
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import SplitResult, parse_qsl, urlsplit

from .driver import DriverError, Reason

__all__ = ["Endpoint", "parse_endpoint", "parse_options", "resolve", "split_address"]


@dataclass(frozen=True)
class Endpoint:
    """Where a controller listens, and the options that stand behind the question mark."""

    host: str
    port: int
    options: Mapping[str, str]

    def number(self, name: str, default: int) -> int:
        """Return an option as a whole number that is not negative.

        Raises:
            DriverError: BAD_ADDRESS for anything else.
        """
        text = self.options.get(name, str(default))
        if not text.isdecimal():
            raise DriverError(Reason.BAD_ADDRESS, f"option {name}={text} is not a whole number")
        return int(text)

    def sign(self, name: str) -> int:
        """Return an option that is 1 or -1; 1 where it is not given.

        Raises:
            DriverError: BAD_ADDRESS for anything else.
        """
        text = self.options.get(name, "1")
        if text not in ("1", "-1"):
            raise DriverError(Reason.BAD_ADDRESS, f"option {name}={text} is neither 1 nor -1")
        return int(text)

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def parse_endpoint(
    address: str, default_port: int, options: tuple[str, ...] = (), default_host: str = ""
) -> Endpoint:
    """Return the endpoint that an address names.

    Args:
        address: ``HOST[:PORT][?option=value&...]``.
        default_port: The port where the address has none.
        options: Names of the options that are understood.
        default_host: The host where the address has none; empty if one must be given.

    Raises:
        DriverError: BAD_ADDRESS, with the notation that would work.
    """
    parts = split_address(f"//{address}")
    try:
        host, port = parts.hostname or default_host, parts.port or default_port
    except ValueError:
        raise bad_address(address, "the port is not a number from 1 to 65535") from None
    if not host:
        raise bad_address(address, "a host is missing")
    if parts.path.strip("/") or parts.username is not None:
        raise bad_address(address, "it has parts that mean nothing here")
    return Endpoint(host, port, parse_options(parts.query, options))


def split_address(address: str) -> SplitResult:
    """Split a URL into its parts.

    Raises:
        DriverError: BAD_ADDRESS when it is none.
    """
    try:
        return urlsplit(address)
    except ValueError as error:
        raise bad_address(address, str(error)) from None


def parse_options(query: str, known: tuple[str, ...]) -> dict[str, str]:
    """Return the options of an address.

    Raises:
        DriverError: BAD_ADDRESS for an option that is malformed or not known.
    """
    try:
        options = dict(parse_qsl(query, strict_parsing=True)) if query else {}
    except ValueError:
        raise bad_address(query, "options are written as ?name=value&name=value") from None
    for name in options:
        if name not in known:
            there_are = f"there are: {', '.join(known)}" if known else "there are none"
            raise DriverError(Reason.BAD_ADDRESS, f"no option is called {name!r}; {there_are}")
    return options


def resolve(host: str) -> str:
    """Return a host's IPv4 address.

    Raises:
        DriverError: UNREACHABLE when the name is not known.
    """
    try:
        return socket.gethostbyname(host)
    except (OSError, UnicodeError):
        raise DriverError(
            Reason.UNREACHABLE, f"no host is called {host!r}; give the robot's IP address"
        ) from None


def bad_address(address: str, why: str) -> DriverError:
    """Return the error for an address that cannot be understood."""
    return DriverError(
        Reason.BAD_ADDRESS,
        f"address {address.removeprefix('//')!r}: {why}; expected HOST[:PORT][?option=value]",
    )

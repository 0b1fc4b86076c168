"""Reads addresses as users write them, ``HOST[:PORT][?option=value&...]``, and connects to them."""

import math
import socket
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

from .. import DriverError, Reason

CONNECT_SECONDS = 2.0


class Options(dict[str, str]):
    """Options of an address by name: the part behind its question mark.

    Each method raises a DriverError, BAD_ADDRESS, where an option is something else.
    """

    def integer(self, name: str, default: int) -> int:
        """Return an option as a whole number, decimal or as in 0x2a5."""
        with self._read(name, "a whole number"):
            return int(self[name], 0) if name in self else default

    def integers(self, name: str, default: Sequence[int]) -> tuple[int, ...]:
        """Return an option that is a list of whole numbers, as in 1,2,4."""
        with self._read(name, "a list of whole numbers, as in 1,2,4"):
            return tuple(map(int, self[name].split(",") if name in self else default))

    def signs(self, count: int) -> tuple[int, ...]:
        """Return the option ``signs``, 1 or -1 for each joint."""
        form = f"1 or -1 for each joint ({count})"
        signs = self.numbers("signs", (1,) * count, lambda sign: abs(sign) == 1, form)
        return tuple(map(int, signs))

    def numbers(
        self,
        name: str,
        default: Sequence[float],
        allows: Callable[[float], bool],
        form: str,
    ) -> tuple[float, ...]:
        """Return an option that is a list of as many numbers as there are by default."""
        if name not in self:
            return tuple(default)
        with self._read(name, form):
            numbers = tuple(map(float, self[name].split(",")))
            if len(numbers) != len(default) or not all(map(allows, numbers)):
                raise ValueError
            return numbers

    def positive(self, name: str, default: float) -> float:
        """Return an option as a positive number."""
        with self._read(name, "a positive number"):
            number = float(self.get(name, default))
            if not 0 < number < math.inf:
                raise ValueError
            return number

    def sign(self, name: str, default: int = 1) -> int:
        """Return an option that is 1 or -1."""
        if self.get(name, "1") not in ("1", "-1"):
            raise self.wrong(name, "1 or -1")
        return int(self.get(name, default))

    @contextmanager
    def _read(self, name: str, form: str) -> Generator[None]:
        """Turn a ValueError into the error for an option."""
        try:
            yield
        except ValueError:
            raise self.wrong(name, form) from None

    def wrong(self, name: str, form: str) -> DriverError:
        """Return the error for an option that is not what is wanted."""
        return Reason.BAD_ADDRESS(f"option {name}={self[name]} is not {form}")


@dataclass(frozen=True)
class Endpoint:
    """Host and port of a controller, and options."""

    host: str
    port: int
    options: Options

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def parse_endpoint(
    address: str,
    default_port: int,
    options: tuple[str, ...] = (),
    default_host: str = "",
) -> Endpoint:
    """Return the host, port and known options of ``HOST[:PORT][?option=value&...]``.

    An empty default host means that one must be given; an address that cannot be understood is a
    DriverError, BAD_ADDRESS, with the notation that would work.
    """
    try:
        parts = urlsplit(f"//{address}")
        host, port = parts.hostname or default_host, parts.port or default_port
    except ValueError as error:
        raise bad_address(address, str(error)) from None
    if not host:
        raise bad_address(address, "a host is missing")
    if parts.path.strip("/") or parts.username is not None:
        raise bad_address(address, "leave out the path or the user name")
    return Endpoint(host, port, parse_options(parts.query, options))


def parse_options(query: str, names: tuple[str, ...]) -> Options:
    """Return the options in ``option=value&...``; one that is not known is a BAD_ADDRESS."""
    try:
        options = Options(parse_qsl(query, strict_parsing=True) if query else ())
    except ValueError:
        raise bad_address(
            query, "options are written as ?name=value&name=value"
        ) from None
    for name in options:
        if name not in names:
            there_are = f"there are: {', '.join(names)}" if names else "there are none"
            raise Reason.BAD_ADDRESS(f"no option is called {name!r}; {there_are}")
    return options


def resolve(host: str) -> str:
    """Return a host's IPv4 address; a name that is not known is UNREACHABLE."""
    try:
        return socket.gethostbyname(host)
    except (OSError, UnicodeError):
        raise Reason.UNREACHABLE(
            f"no host is called {host!r}; give the robot's IP address"
        ) from None


def open_tcp(endpoint: Endpoint, advice: str) -> socket.socket:
    """Connect to a robot's controller, or raise UNREACHABLE, with advice where it is refused."""
    try:
        return socket.create_connection(
            (resolve(endpoint.host), endpoint.port), CONNECT_SECONDS
        )
    except ConnectionRefusedError:
        raise Reason.UNREACHABLE(
            f"{endpoint} refused the connection: {advice}"
        ) from None
    except OSError as error:
        raise Reason.UNREACHABLE(
            f"nothing answers at {endpoint} ({error.strerror or error}): check power, address "
            "and cable"
        ) from None


def bad_address(address: str, why: str) -> DriverError:
    """Return the error for an address that cannot be understood."""
    return Reason.BAD_ADDRESS(
        f"address {address!r}: {why}; expected HOST[:PORT][?option=value]"
    )


@contextmanager
def lost(what: str, *errors: type[Exception]) -> Generator[None]:
    """Turn the errors of a line or bus that is lost into a driver's own."""
    try:
        yield
    except (OSError, *errors) as error:
        raise Reason.UNREACHABLE(f"{what} is lost: {error}") from None

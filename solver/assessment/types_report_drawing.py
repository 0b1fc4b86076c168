"""What ``report.json`` holds for its drawings: where the joints were, and where the arm was."""

from typing import Literal

from ..results import Document, Role


class JointRange(Document, kw_only=True, frozen=True):
    """A joint and its limits."""

    name: str
    unit: Literal["rad", "m"]
    lower: float | None
    upper: float | None


class SocketCoverage(Document, kw_only=True, frozen=True):
    """Where the joints were in one socket [rad, m for prismatic joints]."""

    placement: str
    role: Role
    socket: int
    low: tuple[float, ...]
    """Smallest position of each joint."""
    high: tuple[float, ...]
    positions: tuple[tuple[float, ...], ...]
    """Of the samples, thinned out where there are many; shape (N, joints)."""


class Coverage(Document, kw_only=True, frozen=True):
    """How far each joint moved in each socket."""

    joints: tuple[JointRange, ...]
    sockets: tuple[SocketCoverage, ...]

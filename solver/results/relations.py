"""Relations between robots: poses of their bases and of frames, and who visited which socket."""

from typing import Any

from .files import Document

UNSEEN = 0.1
"""A turn whose standard deviation is larger than this counts as unknown [rad]."""


class FramePose(Document, kw_only=True, frozen=True):
    """Pose of a frame in the robot's base, with its uncertainty."""

    name: str
    xyz: tuple[float, float, float]
    """Its origin [m]."""
    rpy: tuple[float, float, float]
    """Its turn about the base's x, then y, then z axis [rad]."""
    xyz_deviation: tuple[float, float, float]
    """Standard deviation of its origin [m]."""
    turn_deviation: tuple[float, float, float]
    """Standard deviation of its turn about the base's x, y and z axes [rad]."""
    sockets: int
    """Number of sockets that have measured coordinates in it."""
    points: int
    """Number of balls that an instrument measured in it."""
    socket_error: float | None
    """Root mean square distance of those sockets from their coordinates [m]; None without any."""

    @property
    def turn_known(self) -> bool:
        """True if its direction is known: one or two places leave it free to turn."""
        return max(self.turn_deviation) < UNSEEN


class BaseToBase(Document, kw_only=True, frozen=True):
    """Pose of a robot's base in the first one's, and the error between their tools."""

    xyz: tuple[float, float, float] | None
    """Origin of the second base in the first [m]; None, here and below, where the recordings
    leave a turn of the one against the other."""
    rpy: tuple[float, float, float] | None
    """Its turn [rad]."""
    xyz_deviation: tuple[float, float, float] | None
    """Standard deviation of the origin [m]."""
    turn_deviation: tuple[float, float, float] | None
    """Standard deviation of the turn about the first base's axes [rad]."""
    tool_deviation: float | None
    """Predicted error of where the second tool stands seen from the first, over the shared region,
    a root mean square [m]."""
    shared_sockets: int
    """Number of sockets that both visited."""
    text: str
    """All that in words."""


class GivenArm(Document, kw_only=True, frozen=True):
    """One of the robots: what was given of it, and how it stood."""

    name: str
    robot: str
    """As it was named to ``mukca solve``."""
    options: dict[str, Any]
    """Further options of it: base, tip, flange, ball."""
    train: tuple[str, ...]
    """Folders of the placements trained on."""
    test: tuple[str, ...]
    """Folders of those held out."""
    postures: list[list[list[float]]]
    """Places of its joints at a sample of each shared socket, seen from the first robot's base,
    shape (sockets, joints + 1, 3) [m]: base first, ball last."""


class VisitedSocket(Document, kw_only=True, frozen=True):
    """A socket, and who was there."""

    name: str
    """Placement and number."""
    xyz: tuple[float, float, float]
    """In the first robot's base [m]."""
    robots: tuple[str, ...]


class ArmsDocument(Document, kw_only=True, frozen=True):
    """Relations between several robots that were calibrated together."""

    format: str = ""
    """Of the file; empty inside of others, and in older files."""
    robots: tuple[str, ...]
    """Their names; the first one's base is the world."""
    between: dict[str, BaseToBase]
    """By ``FIRST_to_SECOND``."""
    frames: tuple[FramePose, ...]
    """Poses of the frames in which positions were measured."""
    arms: tuple[GivenArm, ...] = ()
    """In the order of their names."""
    sockets: tuple[VisitedSocket, ...] = ()

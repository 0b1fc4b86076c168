"""What ``arms.json`` holds, and ``mukca solve --json`` adds: where several robots stand."""

from .calibration import FramePose
from .files import Document

__all__ = ["ArmsDocument", "BaseToBase"]


class BaseToBase(Document, kw_only=True, frozen=True):
    """Where one robot's base stands in the first one's, and how well their tools are tied."""

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
    """How many sockets both visited."""
    text: str
    """All that in words."""


class ArmsDocument(Document, kw_only=True, frozen=True):
    """What several robots that were calibrated together have in common."""

    robots: tuple[str, ...]
    """Their names; the first one's base is the world."""
    between: dict[str, BaseToBase]
    """By ``FIRST_to_SECOND``."""
    frames: tuple[FramePose, ...]
    """Where the frames stand in which positions were measured."""

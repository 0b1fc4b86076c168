"""A sample: one captured configuration, as the recorder keeps it."""

from dataclasses import dataclass, field

from ..errors import fixed

LAST_SOCKET = 999
"""Largest number of a socket."""


@dataclass(frozen=True, slots=True, repr=False)
class Sample:
    """One captured configuration: the joint positions at which the ball sat in a socket.

    It is an average over a moment in which the arm was still.
    """

    position: tuple[float, ...]
    """Joint positions in chain order [rad], [m] for a prismatic joint."""
    socket: int
    """Number of the socket in which the ball sat, from 0."""
    effort: tuple[float, ...] | None = None
    """Torque that each joint exerted on the links beyond it [N m]; None where the robot does not
    measure it."""
    where: str = ""
    """File and line that it was read from, for messages."""
    number: int = 0
    """Counts the captures of a placement from 1; 0 where the file does not number them."""
    time: float | None = None
    """When it was captured [s since 1970, UTC]."""
    stamp: float | None = None
    """The robot's own time of the last averaged state [s]."""
    states: int = 1
    """Number of averaged joint states."""
    spread: tuple[float, ...] | None = None
    """Standard deviation of each joint's position over the averaged states [rad], [m] for a
    prismatic joint."""
    point: tuple[float, float, float] | None = None
    """Ball's position by an instrument, in its frame [m]; None for a ball in a socket."""
    orientation: tuple[float, float, float, float] | None = None
    """Orientation of the ball's link by an instrument, as a unit quaternion x, y, z, w; None where
    it was not measured."""
    turn: tuple[float, ...] = ()
    """Numbers of the orientation as its file has them [rad]."""
    temperature: float | None = None
    """Of the arm [K], or beside what an instrument measured, in any unit."""
    beside: tuple[float, ...] = field(default=(), compare=False)
    """Numbers that count or date the row, in the order of their placement's names."""
    place: int = field(default=0, compare=False)
    """Counts the samples of its socket as recorded, from 1; its placement sets it."""

    @property
    def named(self) -> str:
        """The sample by the number that people read: the recorder's, or that in its socket."""
        return sample_name(self.number, self.place, self.socket)

    def __repr__(self) -> str:
        position = ", ".join(fixed(value, 4) for value in self.position)
        place = f"socket {self.socket}" if self.point is None else "measured"
        return f"Sample({self.number or 'unnumbered'}, {place}: {position})"


def sample_name(number: int, place: int, socket: int) -> str:
    """Return a sample by the recorder's number, or where that is 0 by its place in its socket."""
    return f"sample {number}" if number else f"sample {place} of socket {socket}"

"""A sample: one captured configuration, as the recorder keeps it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..errors import fixed
from .recording_error import RecordingError

LAST_SOCKET = 999
"""Largest number of a socket."""


Configuration = tuple[float, ...]
"""Joint positions in chain order [rad], [m] for a prismatic joint."""


@dataclass(frozen=True, slots=True, repr=False)
class Sample:
    """One captured configuration: the joint positions at which the ball sat in a socket.

    It is an average over a moment in which the arm was still.
    """

    position: Configuration
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
    states: int | None = None
    """Number of averaged joint states; None where it is not known."""
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
        if self.point:
            return f"point {self.place}"
        return sample_name(self.number, self.place, self.socket)

    def __repr__(self) -> str:
        position = ", ".join(fixed(value, 4) for value in self.position)
        place = f"socket {self.socket}" if self.point is None else "measured"
        return f"Sample({self.number or 'unnumbered'}, {place}: {position})"


def sample_name(
    number: int,
    place: int,
    socket: int,
) -> str:
    """Return a sample by the recorder's number, or where that is 0 by its place in its socket."""
    return f"sample {number}" if number else f"sample {place} of socket {socket}"


def numbers_of(values: object, what: str) -> np.ndarray:
    """Return values as an array of finite numbers.

    Raises:
        RecordingError: One of the values, which is called ``what``, is no number.
    """
    try:
        numbers = np.array(values)
        if np.iscomplexobj(numbers):
            raise TypeError("they are complex")
        numbers = numbers.astype(float)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{what}: real numbers are expected: {error}") from None
    flat = np.atleast_1d(numbers)
    places = np.argwhere(~np.isfinite(flat))
    if len(places):
        value = flat[tuple(places[0])]
        raise RecordingError(f"{what}{places[0].tolist()}: {value:g} is no number")
    return numbers


def samples_of_arrays(
    where: str,
    positions: ArrayLike,
    sockets: ArrayLike,
    joint_names: Sequence[str] | None,
    efforts: ArrayLike | None,
    temperatures: ArrayLike | None,
) -> tuple[Sample, ...]:
    """Return samples of arrays as :meth:`.Placement.of_arrays` takes them.

    Raises:
        RecordingError: No samples, shapes that do not fit each other, a number that is none, or a
            socket that is no number from 0 to 999.
    """
    q = numbers_of(positions, f"{where}: positions")
    seats = numbers_of(sockets, f"{where}: sockets")
    tau = 0 * q if efforts is None else numbers_of(efforts, f"{where}: efforts")
    no_warmth = temperatures is None
    warmth = seats if no_warmth else numbers_of(temperatures, f"{where}: temperatures")
    names = q.shape[1:] if joint_names is None else (len(joint_names),)
    of_samples = q.shape[:1] == seats.shape == warmth.shape
    of_joints = q.ndim == 2 and tau.shape == q.shape and q.shape[1:] == names
    if not (of_samples and of_joints):
        raise RecordingError(
            f"{where}: positions of shape {q.shape}, sockets of {seats.shape}, efforts of "
            f"{tau.shape}, temperatures of {warmth.shape} and {len(joint_names or ())} joint names "
            "do not fit: give (samples, joints), (samples,), (samples, joints), (samples,) and a "
            "name for each joint"
        )
    if not len(q):
        raise RecordingError(f"{where}: no samples")
    if not np.isin(seats, np.arange(LAST_SOCKET + 1)).all():
        raise RecordingError(
            f"{where}: sockets are {seats.min():g} to {seats.max():g}; they are whole numbers, "
            f"from 0 to {LAST_SOCKET}"
        )
    rows = zip(q.tolist(), seats.tolist(), tau.tolist(), warmth.tolist(), strict=True)
    return tuple(
        Sample(
            tuple(position),
            int(seat),
            None if efforts is None else tuple(effort),
            temperature=None if no_warmth else temperature,
        )
        for position, seat, effort, temperature in rows
    )

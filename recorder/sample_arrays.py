"""Samples of one's own arrays."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .arrays import numbers_of
from .recording_error import RecordingError
from .sample import LAST_SOCKET, Sample


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
    tau = 0 * q
    if efforts is not None:
        tau = numbers_of(efforts, f"{where}: efforts")
    warmth = 0 * seats
    if temperatures is not None:
        warmth = numbers_of(temperatures, f"{where}: temperatures")
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
    samples: list[Sample] = []
    rows = zip(q.tolist(), seats.tolist(), tau.tolist(), warmth.tolist(), strict=True)
    for position, seat, effort, temperature in rows:
        sample = Sample(
            tuple(position),
            int(seat),
            None if efforts is None else tuple(effort),
            temperature=None if temperatures is None else temperature,
        )
        samples.append(sample)
    return tuple(samples)

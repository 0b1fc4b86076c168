"""Placements, and samples of sockets, that are there twice: one is a copy."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

import numpy as np

from ....recorder import Placement
from .measurements import Measurement, MeasurementError

SAME_ROW, COPIED = 1e-6, 0.5
"""Rows that differ by less are one [rad], [m]; a larger share of them is a copy, rounded maybe."""


def check_distinct(measurements: Sequence[Measurement]) -> None:
    """Refuse a placement, or a socket's samples, that is given twice."""
    by_samples: dict[bytes, Placement] = {}
    for b in (measurement.placement for measurement in measurements):
        if (rows := _rows_of(b).tobytes()) in by_samples:
            a = by_samples[rows]
            raise MeasurementError(
                f"{a.where} and {b.where} are the same placement; name each only once"
            )
        by_samples[rows] = b
    for first, copy in copied_sockets(by_samples.values()):
        raise MeasurementError(
            f"{first} and {copy} are identical, so one is a copy: record that socket anew"
        )


NEAREST = 0.1
"""A held-out placement nearer than this to one that was trained on proves nothing [m]."""
SAME_CONFIGURATION, COMPARED = 1e-3, 200
"""Configurations that differ by less on every joint are the same [rad], [m]; and so many
configurations of a placement are looked at."""
COPIED_SHARE, REPEATED_SHARE = 0.5, 0.9
"""A larger share of the same configurations is a copy; of points, where a plan is measured anew, a
larger share tells nothing of other postures."""


def copied_sockets(placements: Iterable[Placement]) -> Iterator[tuple[str, str]]:
    """Yield the file of a socket's samples, and that of a later socket with most of them again."""
    holders: dict[bytes, list[str]] = {}
    for placement in placements:
        rows = np.round(_rows_of(placement) / SAME_ROW) + 0.0
        for socket in np.unique(placement.sockets).tolist():
            samples = _samples_of(placement, socket)
            rounded = [row.tobytes() for row in rows[placement.sockets == socket]]
            counts = Counter(
                chain.from_iterable(holders.get(row, ()) for row in rounded)
            )
            for file, count in counts.most_common(1):
                if count > COPIED * len(rounded):
                    yield file, samples
            for row in set(rounded):
                holders.setdefault(row, []).append(samples)


def _rows_of(placement: Placement) -> np.ndarray:
    """Return joints, and points: an arm may be led through the same poses at another place."""
    points = [sample.point or () for sample in placement.samples]
    return np.column_stack([placement.positions, points])


def _samples_of(placement: Placement, socket: int) -> str:
    """Return the file of a socket's samples, for messages."""
    file = f"hole_{socket}.csv"
    if placement.path is not None and placement.path / file in placement.files:
        return str(placement.path / file)
    if placement.kind == "points":
        return str(placement.first_file)
    return f"{placement.where} socket {socket}"


def is_copy(
    measured: Measurement, original: Measurement, share: float = COPIED_SHARE
) -> bool:
    """Tell whether more than a share of a placement's configurations are those of another."""
    rows = measured.positions
    rows = rows[:: -(-len(rows) // COMPARED)]
    # the sine, as each placement may count whole turns of its own
    gaps = abs(np.sin((rows[:, None] - original.positions) / 2)).max(2).min(1)
    return 2 * float(np.quantile(gaps, share)) < SAME_CONFIGURATION

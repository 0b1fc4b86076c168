"""Stops of an arm's joints, to which a hand led each of them, and the file that holds them."""

import json
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from ..drivers import JointState
from ..errors import read_json, reason_of
from .files import make_folder, refused, replace_files
from .recording_error import RecordingError
from .turns import TURN

STOPS = "stops.json"
REST = 0.3
"""Time for which a joint that stands at a stop rests [s]."""
STILL = 5e-3
"""Range within which a joint rests [rad, m]."""


@dataclass(frozen=True)
class Stops:
    """The lowest and the highest reading at which each joint rested [rad, m]."""

    ranges: Mapping[str, tuple[float, float]]
    """By joint; of one that turned past the end of its encoder, as if that counted on."""
    wrapped: tuple[str, ...] = ()
    """Joints whose reading jumped by a whole turn on the way."""
    driver: str = ""
    """Driver and address."""

    def write(self, folder: Path) -> None:
        """Write the stops into a folder.

        Raises:
            RecordingError: They cannot be written.
        """
        file = folder / STOPS
        with refused(str(file)):
            make_folder(folder)
            replace_files({file: f"{json.dumps(asdict(self), indent=1)}\n".encode()})


def read_stops(folder: Path) -> Stops:
    """Return the stops that a folder holds.

    Raises:
        RecordingError: It holds none, or they are damaged.
    """
    file = folder / STOPS
    try:
        document = read_json(file)
        ranges = {
            str(joint): (float(lower), float(upper))
            for joint, (lower, upper) in document["ranges"].items()
        }
        return Stops(ranges, tuple(document["wrapped"]), str(document["driver"]))
    except OSError as error:
        raise RecordingError(
            f"{file}: {reason_of(error)}; mukca record --stops --out {folder} makes it"
        ) from None
    except (ValueError, TypeError, KeyError, AttributeError):
        raise RecordingError(
            f"{file}: no file of mukca record --stops; record it again"
        ) from None


@dataclass
class StopFinder:
    """Finds stops in the states of an arm that a hand leads."""

    joints: Sequence[str]
    lower: np.ndarray = field(init=False)
    """The lowest rest of each joint so far, infinite without any, shape (m,) [rad]."""
    upper: np.ndarray = field(init=False)
    wrapped: np.ndarray = field(init=False)
    """True for joints whose reading jumped by a turn."""

    def __post_init__(self) -> None:
        m = len(self.joints)
        self.lower = np.full(m, np.inf)
        self.upper = np.full(m, -np.inf)
        self.wrapped = np.zeros(m, dtype=bool)
        self._window: deque[tuple[float, np.ndarray]] = deque()
        self._last = np.full(m, np.nan)

    def add(self, state: JointState) -> bool:
        """Take the next state; return True while the whole arm rests."""
        q = np.array(state.position)
        if not np.isnan(self._last).any():
            turns = np.round((self._last - q) / TURN)
            self.wrapped |= turns != 0
            q += TURN * turns
        self._last = q
        self._window.append((state.stamp, q))
        if state.stamp - self._window[0][0] < REST:
            return False
        rows = np.array([row for _, row in self._window])
        while state.stamp - self._window[0][0] >= REST:
            self._window.popleft()
        rests = np.ptp(rows, axis=0) < STILL
        places = rows.mean(axis=0)
        self.lower = np.where(rests, np.minimum(self.lower, places), self.lower)
        self.upper = np.where(rests, np.maximum(self.upper, places), self.upper)
        return bool(rests.all())

    def stops(self, driver: str = "") -> Stops:
        """Return what was found; joints that never rested are missing."""
        rows = zip(self.joints, self.lower.tolist(), self.upper.tolist(), strict=True)
        ranges = {joint: (low, high) for joint, low, high in rows if low <= high}
        names = [j for j, past in zip(self.joints, self.wrapped, strict=True) if past]
        return Stops(ranges, tuple(names), driver)


def follow_to_stops(
    states: Iterator[JointState],
    joints: Sequence[str],
    pause: float,
) -> Iterator[StopFinder]:
    """Yield what was found after each state, until the arm has rested for so long [s]."""
    finder = StopFinder(joints)
    moved: float | None = None
    for state in states:
        if not finder.add(state) or moved is None:
            moved = state.stamp
        yield finder
        if state.stamp - moved > pause:
            return

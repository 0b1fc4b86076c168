"""Evidence of an inspection: robust fits to each placement alone and to all together.

No fit here believes the sockets' distances, and none can fail to settle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import CALIPER_DEVIATION, KnownDistance, Measurement
from ..robot import Robot, choose_parameters
from .change_points import Change, Segment, find_segments
from .diagnostic import Diagnostic
from .distances import named
from .fit_error import standing_out, unexplained
from .robust_fit import RigidFit, RigidModel, samples_of

NEAR = 3e-3
"""Centres nearer than this [m], or ten deviations, may be those of one socket."""
LOOSE, MAX_BACKLASH_MOVE = 5e-4, 5e-3
"""Noise of an arm whose gears have backlash [m], and how far that may move a socket [m]."""


@dataclass(frozen=True)
class Displacement:
    """A segment that lies away from the other samples of its socket."""

    segment: Segment
    socket: int
    """Number of its socket in the placement."""
    other: tuple[str, int] | None
    """Placement and number of the socket in which it lies; None where the base moved."""
    change: Change


@dataclass(frozen=True)
class Evidence:
    """Recordings, and what fits to them show, for all checks."""

    robot: Robot
    measurements: Sequence[Measurement]
    known: Sequence[KnownDistance]
    deviation: float
    zeros: bool
    model: RigidModel
    alone: dict[str, tuple[RigidFit, list[Segment]]]
    """The fit to each placement alone and its segments, by name."""
    bad: dict[str, list[Diagnostic]]
    """Errors of each placement that a fit does not explain as it does the others."""
    good: Sequence[Measurement]
    """All other placements."""
    together: RigidFit
    """The fit to them."""
    segments: Sequence[Segment]
    """Their segments, those that are the sockets' own first."""
    labels: tuple[tuple[str, int], ...]
    """Placement and number of each of their sockets."""

    @property
    def centres(self) -> np.ndarray:
        """Centres of the sockets, shape (S, 3) [m]."""
        return self.together.centres[: len(self.labels)]

    def displacements(self, measured: Measurement) -> list[Displacement]:
        """Return the segments of a placement that lie away from their socket."""
        found: list[Displacement] = []
        for index in range(len(self.labels), len(self.segments)):
            segment = self.segments[index]
            name, socket = self.labels[segment.socket]
            if name != measured.name:
                continue
            own, place = self.centres[segment.socket], self.together.centres[index]
            jump = float(np.linalg.norm(place - own))
            if jump < max(NEAR / 4, self.together.noise):
                continue  # the base is back where it was
            other = self._socket_at(place, but=segment.socket) if jump > 2 * NEAR else None
            before = segment.end <= self.segments[segment.socket].begin
            change = Change(socket, segment.end if before else segment.begin, jump)
            found.append(Displacement(segment, socket, other, change))
        return found

    def _socket_at(self, place: np.ndarray, but: int) -> tuple[str, int] | None:
        """Return the socket at a place, other than one; None where there is none."""
        away = np.linalg.norm(self.centres - place, axis=1)
        away[but] = np.inf
        nearest = int(np.argmin(away))
        return self.labels[nearest] if away[nearest] < max(NEAR, 10 * self.together.noise) else None

    def moves(self, measured: Measurement) -> tuple[Change, ...]:
        """Return the moves of a placement's base."""
        moves = [one.change for one in self.displacements(measured) if one.other is None]
        return tuple(sorted(moves, key=lambda change: (change.socket, change.sample)))

    def explained_by_backlash(self, change: Change) -> bool:
        """Return True where gears with backlash, not spoken of, would look like this move, too."""
        loose = self.together.noise > LOOSE and change.jump < MAX_BACKLASH_MOVE
        return loose and not self.zeros


def gather(
    robot: Robot,
    measurements: Sequence[Measurement],
    *,
    known: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
    zeros: bool = False,
) -> Evidence:
    """Fit placements alone and together; see :func:`.inspection.inspect_all`."""
    model = RigidModel(robot, choose_parameters(robot), zeros=zeros)
    known = named(measurements, known)
    alone = {m.name: find_segments(model, samples_of([m])) for m in measurements}
    floors = [fit.error for fit, _ in alone.values()]
    bad = {
        m.name: [] if typical is None else unexplained(model, m, floor, typical)
        for m, floor, typical in zip(measurements, floors, standing_out(floors), strict=True)
    }
    good = [m for m in measurements if not bad[m.name]]
    fit, segments = (
        alone[good[0].name] if len(good) == 1 else find_segments(model, samples_of(good))
    )
    labels = tuple((m.name, socket) for m in good for socket in m.sockets)
    return Evidence(
        robot, measurements, known, deviation, zeros, model, alone, bad, good, fit, segments, labels
    )

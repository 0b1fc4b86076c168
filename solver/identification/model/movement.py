"""The place of a socket base, or of an instrument, over the time of its recording."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..data import Clock, Observations
from .prior_group import PriorGroup

SIZE = 1e-3
"""Usual size of a step, and of a drift from the first sample to the last [m]."""
WAVES = 8
"""Waves of a slow process at most: the k-th goes to and fro k / 2 times, and is k^2 times smaller
than the first, as those of a path whose speed is a random walk."""
EACH = 4
"""Samples for each wave."""


@dataclass(frozen=True)
class Movement:
    """Movement of one placement while it is recorded."""

    placement: str
    kind: Literal["step", "drift", "slow", "difference"]
    clock: Clock = "time"
    """Clock that it follows, ``time`` or ``temperature``."""
    at: float = 0.0
    """When a step was made: from this time on, since the first sample."""
    waves: int = 1

    @property
    def weights(self) -> np.ndarray:
        """w_k, shape (K,)."""
        return 1 / np.arange(1, self.waves + 1) ** 2

    @property
    def size(self) -> int:
        """Number of its unknowns, u_k after u_k."""
        return 3 * self.waves

    def course(self, data: Observations) -> np.ndarray:
        """Return c_k of each sample of a robot, shape (N, K); zero for samples elsewhere."""
        rows = data.rows_of(self.placement)
        course = np.zeros((len(rows), self.waves))
        if not rows.any():
            return course
        t = data.clock(self.clock)[rows, 0]
        duration = max(float(np.ptp(t)), 1e-12)
        s = (t - t.min()) / duration
        if self.kind == "step":
            course[rows, 0] = t >= self.at
        elif self.kind == "drift":
            course[rows, 0] = s - 0.5
        else:
            k = np.arange(1, self.waves + 1)
            halves = np.pi * k
            course[rows] = np.cos(s[:, None] * halves)
        return course

    def slopes(self, data: Observations) -> np.ndarray:
        """Return the derivatives of m by the unknowns for all samples, shape (N, 3, size)."""
        course = self.course(data)
        by_axis = np.einsum("nk,ij->nikj", course, np.eye(3))
        return by_axis.reshape(len(course), 3, -1)

    def prior(self, begin: int) -> PriorGroup:
        """Return the prior of its unknowns, from some index on: of a slow process learned."""
        slow = self.kind == "slow"
        variances = np.repeat(self.weights**2, 3)
        return PriorGroup(
            f"{self.kind} of {self.placement}",
            "m",
            np.arange(begin, begin + self.size),
            SIZE,
            typical=SIZE if slow else 0.0,
            learned=slow,
            shape=np.diag(variances),
        )


@dataclass(frozen=True)
class FoundMovement:
    """A movement that the data support."""

    placement: str
    text: str
    kept: bool
    """True where it is in the model."""
    rank: int | None = None
    """Of a step, the number of samples that were recorded before."""


def movements_of(data: Observations, placement: str) -> list[Movement]:
    """Return the movements that a placement's samples could tell, from its clocks."""
    rows = data.rows_of(placement)
    clocks: tuple[Clock, ...] = ("time", "temperature")
    movements: list[Movement] = []
    for clock in clocks:
        t = data.clock(clock)[rows, 0]
        waves = min(WAVES, len(t) // EACH)
        if waves < 1 or not np.isfinite(t).all():
            continue
        if not np.ptp(t):
            continue
        if clock == "time":
            for change in _changes(t, data.sockets[rows]):
                movements.append(Movement(placement, "step", at=change))
            movements.append(Movement(placement, "drift"))
        movements.append(Movement(placement, "slow", clock, waves=waves))
    return movements


def _changes(t: np.ndarray, sockets: np.ndarray) -> list[float]:
    """Return the times of the changes of socket, but those that split no socket's samples."""
    order = np.argsort(t, kind="stable")
    ordered: list[int] = sockets[order].tolist()
    times: list[float] = t[order].tolist()
    changes: list[float] = []
    for i in range(1, len(times)):
        if ordered[i] == ordered[i - 1]:
            continue
        before = {*ordered[:i]}
        if not before.isdisjoint(ordered[i:]):
            changes.append(times[i])
    return changes

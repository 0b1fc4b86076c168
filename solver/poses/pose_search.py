"""Searches for joint positions, many at a time, and the rules by which each of them ends."""

from dataclasses import dataclass, fields

import numpy as np

SETTLED = 1e-3
"""A smaller step toward the preferred posture is the last one [rad]."""
STUCK, NEAR = 12, 1e-5
"""So many rounds that do not halve the residual end a search, once its square is less than NEAR: at
a singular configuration, or where a limit is in the way."""
AWAY, MARGIN = 3, 2.0
"""In the first of these rounds joints keep a distance from their limits, this multiple of the root
of the residual: an arm that is singular at a limit reaches a pose near it by way of others."""
SHORTEST = 0.3
"""In the other rounds, the least share of a step that is taken, see :meth:`Searches.move`."""
TINY = 1e-300
"""Keeps divisors from zero."""
STILL = 1e-3
"""A step that is smaller relative to the residual ends a search, too [rad/m]."""
NO_MARGIN = np.zeros((1, 1))


@dataclass(frozen=True)
class SearchStep:
    """Steps of N searches."""

    residual: np.ndarray
    """Distance [m] and angle [rad] that were left before the step, shape (N, 2)."""
    change: np.ndarray
    """Of the joint positions, shape (N, m) [rad]."""
    longest: np.ndarray
    """Largest change of a joint, shape (N,) [rad]."""

    @property
    def largest(self) -> np.ndarray:
        """The larger of distance and angle, shape (N,)."""
        return np.maximum(self.residual[:, 0], self.residual[:, 1])

    @property
    def square(self) -> np.ndarray:
        """Sum of the squares of distance and angle, shape (N,)."""
        return np.square(self.residual) @ np.ones(2)

    @property
    def settled(self) -> np.ndarray:
        """True where the arm hardly moves, shape (N,)."""
        return self.longest < SETTLED


@dataclass
class Searches:
    """N searches that go on, each in a row of the arrays."""

    pose: np.ndarray
    """Index of the pose that is sought, shape (N,)."""
    rows: np.ndarray
    """Joint positions q, the target's [R | p] by rows, and the posture to stay near, a row each,
    shape (N, 2 m + 12) [rad], [m]."""
    best: np.ndarray
    """Joint positions that left least so far, shape (N, m) [rad]."""
    residual: np.ndarray
    """Residual that these left, shape (N, 2)."""
    square: np.ndarray
    """Least sum of squares so far, shape (N,)."""
    change: np.ndarray
    """The step before, shape (N, m) [rad]."""
    stalls: np.ndarray
    """Rounds in a row that did not halve the residual, shape (N,)."""

    @classmethod
    def begun(
        cls,
        q: np.ndarray,
        target: np.ndarray,
        posture: np.ndarray,
    ) -> "Searches":
        """Return searches from joint positions."""
        N = len(q)
        rows = np.hstack([q, target, posture])
        return cls(
            pose=np.arange(N),
            # columns are contiguous, since these are computed with
            rows=np.asfortranarray(rows),
            best=q.copy(),
            residual=np.full((N, 2), np.inf),
            square=np.full(N, np.inf),
            change=q,
            stalls=np.zeros(N, dtype=int),
        )

    @property
    def q(self) -> np.ndarray:
        """Joint positions, shape (N, m) [rad]."""
        return self.rows[:, : self.best.shape[1]]

    @property
    def margins(self) -> np.ndarray:
        """Distance that joints keep from their limits, shape (N, 1) or (1, 1) [rad]."""
        away = (self.stalls > 0) & (self.stalls <= AWAY)
        if not away.any():
            return NO_MARGIN
        margins = MARGIN * np.sqrt(np.sqrt(self.square))
        return np.where(away, margins, 0.0)[:, None]

    def shrinkage(self, step: SearchStep) -> np.ndarray:
        """Return the residual as a share of the least before, shape (N,)."""
        return np.sqrt(step.square / np.maximum(self.square, TINY))

    def keep(
        self,
        step: SearchStep,
        ends: np.ndarray,
    ) -> None:
        """Keep the joint positions that leave least so far, and those at which a search ends."""
        better = ends | (step.square <= self.square)
        kept = better[:, None]
        np.copyto(self.best, self.q, where=kept)
        np.copyto(self.residual, step.residual, where=kept)

    def move(self, step: SearchStep) -> None:
        """Take the steps, shorter ones where a search is stuck and they alternate in sign.

        With a step s, and d how it differs from the one before, it is scaled by 1 - s . d / d . d
        (Aitken's relaxation).
        """
        halved = step.square < self.square / 4
        progress = halved | (self.square > NEAR)
        self.stalls = np.where(progress, 0, self.stalls + 1)
        still = step.longest < STILL * step.largest
        self.stalls[still] = STUCK
        self.square = np.fmin(step.square, self.square)
        slow = self.stalls > AWAY
        scale = np.ones((len(slow), 1))
        if slow.any():
            s = step.change[slow]
            d = s - self.change[slow]
            squares = (d * d).sum(axis=1)
            moves = (s * d).sum(axis=1) / np.maximum(squares, TINY)
            scale[slow, 0] = (1 - moves).clip(SHORTEST, 1)
        q = self.q
        q += step.change * scale
        self.change = step.change
        posture = self.rows[:, -q.shape[1] :]
        np.copyto(posture, q, where=step.settled[:, None])

    def where(self, chosen: np.ndarray) -> "Searches":
        """Return some of the searches."""
        arrays = [getattr(self, entry.name) for entry in fields(self)]
        rows = [values.T.compress(chosen, axis=-1).T for values in arrays]
        return Searches(*rows)

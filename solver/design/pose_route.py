"""Poses and their order, chosen together: as informative as the best ones, with less travel.

The poses that teach most, taken one by one, lie at the ends of the joints' ranges, so that the arm
is turned over from each to the next. Of many sets of poses that teach about as much, simulated
annealing (Kirkpatrick, Gelatt and Vecchi 1983) finds one with a short way through it. A pose is
drawn anew from its socket's pool, all others held, with probabilities exp(-cost / temperature)
(heat bath), and poses of one socket change places in the same manner. The cost is of the whole way;
mean variances (D2), with the arm's scale and without it, may not exceed those of the poses that
teach most.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from .information import (
    ParameterCovariance,
    Prospect,
    Workspace,
    updated,
    with_and_without_scale,
)

DRAWN = 100
"""Poses of the pool that are compared at a time."""
SWEEPS, AGAIN = 60, 12
"""Times that each pose is drawn anew, at first, and where an earlier way is improved."""
HOT, WARM, COLD = 0.3, 0.02, 0.003
"""Temperatures: at first, of an earlier way, and at the end."""
SLACK = np.array([1.05, 1.12]) ** 2
"""Mean variances may be so many times those of the poses that teach most: with the arm's scale, and
without it."""
HARD = 30.0
"""Cost of a logarithm of the mean variance above the allowed one."""
LONG = np.deg2rad(120)
"""A step that turns a joint farther is awkward, with the ball in a socket [rad]."""


def _costs(ways: np.ndarray, turns: np.ndarray, typical: np.ndarray) -> np.ndarray:
    """Return the costs of ways that differ in some poses next to each other, shape (K, P, m).

    A way costs the turns of joint 1, of the joint that turns most, and of all joints, each as a
    share of what is typical, shape (m,); and each step for its longest turn, much if it is awkward.
    ``turns`` are those of the joints in all steps, shape (T, m), zero between those poses.
    """
    turned = np.abs(np.diff(ways, axis=1))
    total = turns.sum(axis=0) + turned.sum(axis=1)
    by_base = 1.2 * total[:, 0] / typical[0]
    by_largest = total.max(axis=1) / typical.max()
    by_all = total.sum(axis=1) / typical.sum()

    def steps(turns_of_steps: np.ndarray) -> np.ndarray:
        longest = turns_of_steps.max(axis=-1)
        awkward = np.maximum(longest / LONG - 0.9, 0)
        return np.sum(awkward + 2 / len(turns) * np.sqrt(longest), axis=-1)

    return by_base + by_largest + by_all + steps(turned) + steps(turns)


class Annealing:
    """State of the annealing: the chosen poses, and the covariance after them."""

    sweeps = SWEEPS
    slack = SLACK

    def __init__(
        self,
        prior: np.ndarray,
        rows: Mapping[int, np.ndarray],
        projection: np.ndarray,
        pools: Mapping[int, np.ndarray],
        order: Sequence[int],
        start: np.ndarray | None = None,
    ) -> None:
        self.prior = prior
        self.rows = rows
        self.judged = projection
        self.pools = pools
        self.order = list(order)
        self.start = start
        self.chosen = np.zeros(len(order), dtype=int)
        self.generator = np.random.default_rng(0)
        self._first = 0 if start is None else 1
        self._way = np.zeros((0, 0))

    def greedy(self) -> np.ndarray:
        """Choose the poses that teach most, one by one, and return the covariance after them."""
        covariance = self.prior
        for t, k in enumerate(self.order):
            _, relative = self.seen(covariance, self.rows[k]).mean_variances
            self.chosen[t] = int(np.argmin(relative))
            covariance = self.updated(covariance, self.rows[k][self.chosen[t]])
        return covariance

    def near(self, poses: np.ndarray) -> None:
        """Choose the poses of the pools that are nearest to some, in their order."""
        for t, (k, q) in enumerate(zip(self.order, poses, strict=False)):
            self.chosen[t] = int(np.argmin(np.abs(self.pools[k] - q).max(axis=1)))

    def poses(self) -> np.ndarray:
        """Return the chosen way, from the start on where it is known, shape (T, m)."""
        way = [self.pools[k][i] for k, i in zip(self.order, self.chosen, strict=True)]
        return np.stack(way if self.start is None else [self.start, *way])

    def covariance(self) -> np.ndarray:
        """Return the covariance after all chosen poses."""
        some = [self.rows[k][i] for k, i in zip(self.order, self.chosen, strict=True)]
        return self.updated(self.prior, np.concatenate(some))

    def updated(self, covariance: np.ndarray, rows: np.ndarray, sign: int = 1) -> np.ndarray:
        """Return a covariance after more samples, or without some (sign -1)."""
        return updated(covariance, rows, sign)

    def seen(self, covariance: np.ndarray, rows: np.ndarray) -> Prospect:
        """Return what samples would tell, after a state of the annealing."""
        return Prospect.of(covariance, rows, self.judged)

    def allowed(self) -> np.ndarray:
        """Return both mean variances that no way may exceed, by the chosen poses, shape (2,)."""
        none = next(iter(self.rows.values()))[:0]
        return self.slack * with_and_without_scale(self.seen(self.covariance(), none).variances)

    def anneal(self, hot: float, sweeps: int, allowed: np.ndarray, typical: np.ndarray) -> None:
        """Draw each pose anew so many times, while it cools."""
        self._way = self.poses()
        for temperature in np.geomspace(hot, COLD, sweeps):
            covariance = self.covariance()
            for t in map(int, self.generator.permutation(len(self.order))):
                covariance = self._drawn_anew(t, covariance, allowed, typical, temperature)
                self._exchange(t, typical, temperature)

    def _drawn_anew(
        self,
        t: int,
        covariance: np.ndarray,
        allowed: np.ndarray,
        typical: np.ndarray,
        temperature: float,
    ) -> np.ndarray:
        """Draw the pose of a sample from its pool, all others held; return the covariance after."""
        k = self.order[t]
        rows = self.rows[k]
        remainder = self.updated(covariance, rows[self.chosen[t]], -1)
        some = self.generator.integers(len(rows), size=DRAWN)
        some[0] = self.chosen[t]
        position = t + self._first
        begin = max(position - 1, 0)
        turns = np.abs(np.diff(self._way, axis=0))
        turns[begin : position + 1] = 0
        ways = np.tile(self._way[begin : position + 2], (DRAWN, 1, 1))
        ways[:, position - begin] = self.pools[k][some]
        variances = self.seen(remainder, rows[some]).mean_variances
        excess = np.log(variances / allowed[:, None]).clip(0)
        cost = _costs(ways, turns, typical) + HARD * excess.sum(axis=0)
        drawn = some[self._draw(cost, temperature)]
        if drawn == self.chosen[t]:
            return covariance
        self.chosen[t] = drawn
        self._way[position] = self.pools[k][drawn]
        return self.updated(remainder, rows[drawn])

    def _exchange(self, t: int, typical: np.ndarray, temperature: float) -> None:
        """Let a pose change places with one of its socket, or stay."""
        matches = np.flatnonzero(np.array(self.order) == self.order[t])
        places = np.tile(np.arange(len(self._way)), (len(matches), 1))
        places[:, t + self._first] = matches + self._first
        places[np.arange(len(matches)), matches + self._first] = t + self._first
        still = np.zeros_like(self._way[1:])
        swap = self._draw(_costs(self._way[places], still, typical), temperature)
        self._way = self._way[places[swap]]
        partner = matches[swap]
        self.chosen[[t, partner]] = self.chosen[[partner, t]]

    def way(self, before: np.ndarray | None) -> np.ndarray:
        """Return the poses in their order, see :func:`plan_poses`, shape (T, m)."""
        self.greedy()
        allowed = self.allowed()
        typical = np.abs(np.diff(self.poses(), axis=0)).sum(axis=0).clip(1e-3)
        if before is None:
            self.anneal(HOT, self.sweeps, allowed, typical)
        else:
            self.near(before)
            self.anneal(WARM, AGAIN, allowed, typical)
        return self.poses()[-len(self.order) :]

    def _draw(self, cost: np.ndarray, temperature: float) -> int:
        """Return one of some states, by their costs."""
        sums = np.cumsum(np.exp((cost.min() - cost) / temperature))
        return int(np.searchsorted(sums, self.generator.uniform() * float(sums[-1])))


def plan_poses(
    state: ParameterCovariance,
    where: Workspace,
    pools: Mapping[int, np.ndarray],
    order: Sequence[int],
    start: np.ndarray | None = None,
    before: np.ndarray | None = None,
) -> np.ndarray:
    """Return poses for the samples to come, in their order, shape (T, m) [rad].

    Args:
        state: The covariance so far.
        where: Distances to be known.
        pools: For each socket in the order, poses that reach it, shape (N, m).
        order: The socket of each sample to come, T of them.
        start: The arm's pose now, shape (m,).
        before: A way that was returned before, of which this is the rest: only improved.
    """
    rows = {k: state.whitened(pools[k], k) for k in set(order)}
    return Annealing(state.covariance, rows, where.judged, pools, order, start).way(before)

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
    Workspace,
    joint_covariance,
    mean_variances,
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

    ``others`` are the turns of the joints in all steps, shape (T, m), zero between those poses;
    another way turns the joints as usual.
    """
    turned = np.abs(ways[:, 1:] - ways[:, :-1])
    total = turns.sum(axis=0) + turned.sum(axis=1)
    largest = turned.max(axis=2)
    shares = 1.2 * total[:, 0] / typical[0] + total.max(axis=1) / typical.max()

    def steps(longest: np.ndarray) -> np.ndarray:
        awkward = np.maximum(longest / LONG - 0.9, 0) + 2 / len(turns) * np.sqrt(longest)
        return awkward.sum(axis=-1)

    return shares + total.sum(axis=1) / typical.sum() + steps(largest) + steps(turns.max(axis=1))


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
        self.prior, self.rows, self.judged = prior, rows, projection
        self.pools, self.order, self.start = pools, list(order), start
        self.chosen = np.zeros(len(order), dtype=int)
        self.generator = np.random.default_rng(0)

    def greedy(self) -> np.ndarray:
        """Choose the poses that teach most, one by one, and return the covariance after them."""
        covariance = self.prior
        for t, k in enumerate(self.order):
            variances = self._variances(covariance, self.rows[k])[1]
            self.chosen[t] = int(np.argmin(variances))
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

    def seen(
        self, covariance: np.ndarray, rows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return :func:`.joint_covariance` of samples, after a state of the annealing."""
        return joint_covariance(covariance, rows, self.judged)

    def allowed(self) -> np.ndarray:
        """Return both mean variances that no way may exceed, by the chosen poses, shape (2,)."""
        none = next(iter(self.rows.values()))[:0]
        return self.slack * with_and_without_scale(self.seen(self.covariance(), none)[2])

    def _variances(self, covariance: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return both mean variances after each of some samples, shape (2, N)."""
        return mean_variances(*self.seen(covariance, rows))

    def anneal(self, hot: float, sweeps: int, allowed: np.ndarray, typical: np.ndarray) -> None:
        """Draw each pose anew so many times, while it cools."""
        way = self.poses()
        order = np.array(self.order)
        first = len(way) - len(order)
        still = np.zeros_like(way[1:])
        for temperature in np.geomspace(hot, COLD, sweeps):
            covariance = self.covariance()
            for t in map(int, self.generator.permutation(len(order))):
                k = self.order[t]
                rows = self.rows[k]
                position = t + first
                remainder = self.updated(covariance, rows[self.chosen[t]], -1)
                some = self.generator.integers(len(rows), size=DRAWN)
                some[0] = self.chosen[t]
                begin = max(position - 1, 0)
                turns = np.abs(way[1:] - way[:-1])
                turns[begin : position + 1] = 0
                ways = np.tile(way[begin : position + 2], (DRAWN, 1, 1))
                ways[:, position - begin] = self.pools[k][some]
                over = np.log(self._variances(remainder, rows[some]) / allowed[:, None]).clip(0)
                cost = _costs(ways, turns, typical) + HARD * over.sum(axis=0)
                drawn = some[self._draw(cost, temperature)]
                if drawn != self.chosen[t]:
                    self.chosen[t], way[position] = drawn, self.pools[k][drawn]
                    covariance = self.updated(remainder, rows[drawn])
                matches = np.flatnonzero(order == k)
                places = np.tile(np.arange(len(way)), (len(matches), 1))
                places[:, position] = matches + first
                places[np.arange(len(matches)), matches + first] = position
                swap = self._draw(_costs(way[places], still, typical), temperature)
                way = way[places[swap]]
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

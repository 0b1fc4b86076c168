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


def _turns(ways: np.ndarray) -> np.ndarray:
    """Return the turns of the joints in each step of ways, (..., T, m), as (..., T - 1, m)."""
    return np.abs(np.diff(ways, axis=-2))


def _costs(
    ways: np.ndarray,
    turns: np.ndarray,
    typical: np.ndarray,
) -> np.ndarray:
    """Return the costs of ways that differ in some poses next to each other, shape (K, P, m).

    A way costs the turns of joint 1, of the joint that turns most, and of all joints, each as a
    share of what is typical, shape (m,); and each step for its longest turn, much if it is awkward.
    ``turns`` are those of the joints in all steps, shape (T, m), zero between those poses.
    """
    turned = _turns(ways)
    total = turns.sum(axis=0) + turned.sum(axis=1)
    by_base = 1.2 * total[:, 0] / typical[0]
    by_largest = total.max(axis=1) / typical.max()
    by_all = total.sum(axis=1) / typical.sum()
    of_step = 2 / len(turns)

    def steps(turns_of_steps: np.ndarray) -> np.ndarray:
        longest = turns_of_steps.max(axis=-1)
        costs = np.maximum(longest / LONG - 0.9, 0) + of_step * np.sqrt(longest)
        return costs.sum(axis=-1)

    return by_base + by_largest + by_all + steps(turned) + steps(turns)


class Annealing:
    """State of the annealing: the chosen poses among those of all pools, one for each sample.

    ``prior`` is the covariance before them, and ``rows`` are derivatives by all poses, pool after
    pool, shape (P, 3, n), or what a subclass has in their place; ``judged`` is that of
    :class:`.Workspace`; the others as for :func:`plan_poses`.
    """

    sweeps = SWEEPS
    slack = SLACK

    def __init__(
        self,
        prior: np.ndarray,
        rows: np.ndarray,
        judged: np.ndarray,
        pools: Mapping[int, np.ndarray],
        order: Sequence[int],
        start: np.ndarray | None = None,
    ) -> None:
        self.prior = prior
        self.rows = rows
        self.judged = judged
        self.order = np.array(order)
        self.start = start
        self.poses = np.concatenate([*pools.values()])
        self.pools: dict[int, slice] = {}
        begin = 0
        for k, pool in pools.items():
            end = begin + len(pool)
            self.pools[k] = slice(begin, end)
            begin = end
        self.chosen = np.zeros(len(order), dtype=int)
        self.generator = np.random.default_rng(0)
        self._allowed = np.zeros(2)
        self._typical = np.zeros(self.poses.shape[1])

    def greedy(self) -> np.ndarray:
        """Choose the poses that teach most, one by one, and return the covariance after them."""
        covariance = self.prior
        for t, k in enumerate(self.order):
            pool = self.pools[k]
            _, relative = self.seen(covariance, self.rows[pool]).mean_variances
            pose = pool.start + np.argmin(relative)
            self.chosen[t] = pose
            covariance = self.updated(covariance, self.rows[pose])
        return covariance

    def near(self, poses: np.ndarray) -> None:
        """Choose the poses of the pools that are nearest to some, in their order."""
        for t, q in enumerate(poses[: len(self.order)]):
            pool = self.pools[self.order[t]]
            offsets = np.abs(self.poses[pool] - q)
            self.chosen[t] = pool.start + np.argmin(offsets.max(axis=1))

    def ways(self, chosen: np.ndarray) -> np.ndarray:
        """Return ways through chosen poses, (..., T), from a known start on, (..., T + 1, m)."""
        ways = self.poses[chosen]
        if self.start is None:
            return ways
        starts = np.empty_like(ways[..., :1, :])
        starts[...] = self.start
        return np.concatenate([starts, ways], axis=-2)

    def covariance(self) -> np.ndarray:
        """Return the covariance after all chosen poses."""
        return self.updated(self.prior, np.concatenate(self.rows[self.chosen]))

    def updated(
        self,
        covariance: np.ndarray,
        rows: np.ndarray,
        sign: int = 1,
    ) -> np.ndarray:
        """Return a covariance after more samples, or without some (sign -1)."""
        return updated(covariance, rows, sign)

    def seen(
        self,
        covariance: np.ndarray,
        rows: np.ndarray,
    ) -> Prospect:
        """Return what samples would tell, after a state of the annealing."""
        return Prospect.of(covariance, rows, self.judged)

    def allowed(self) -> np.ndarray:
        """Return both mean variances that no way may exceed, by the chosen poses, shape (2,)."""
        prospect = self.seen(self.covariance(), self.rows[:0])
        return self.slack * with_and_without_scale(prospect.variances)

    def way(self, before: np.ndarray | None) -> np.ndarray:
        """Return the poses in their order, see :func:`plan_poses`, shape (T, m)."""
        self.greedy()
        self._allowed = self.allowed()
        total = _turns(self.ways(self.chosen)).sum(axis=0)
        self._typical = total.clip(1e-3)
        if before is None:
            self._anneal(HOT, self.sweeps)
        else:
            self.near(before)
            self._anneal(WARM, AGAIN)
        return self.poses[self.chosen]

    def _anneal(self, hot: float, sweeps: int) -> None:
        """Draw each pose anew so many times, while it cools."""
        for temperature in np.geomspace(hot, COLD, sweeps):
            covariance = self.covariance()
            for t in self.generator.permutation(len(self.order)):
                covariance = self._drawn_anew(t, covariance, temperature)
                self._exchange(t, temperature)

    def _drawn_anew(
        self,
        t: int,
        covariance: np.ndarray,
        temperature: float,
    ) -> np.ndarray:
        """Draw the pose of a sample from its pool, all others held; return the covariance after."""
        old = self.chosen[t]
        remainder = self.updated(covariance, self.rows[old], -1)
        pool = self.pools[self.order[t]]
        drawn = self.generator.integers(pool.stop - pool.start, size=DRAWN)
        some = pool.start + drawn
        some[0] = old
        prospect = self.seen(remainder, self.rows[some])
        excess = np.log(prospect.mean_variances / self._allowed[:, None]).clip(0)
        of_ways = self._costs_with(t, self.poses[some])
        new = some[self._draw(of_ways + HARD * excess.sum(axis=0), temperature)]
        if new == old:
            return covariance
        self.chosen[t] = new
        return self.updated(remainder, self.rows[new])

    def _costs_with(self, t: int, poses: np.ndarray) -> np.ndarray:
        """Return the costs of the ways with other poses for a sample, shape (K, m), as (K,)."""
        way = self.ways(self.chosen)
        position = t + len(way) - len(self.chosen)
        begin = max(position - 1, 0)
        turns = _turns(way)
        turns[begin : position + 1] = 0
        part = way[begin : position + 2]
        ways = np.tile(part, (len(poses), 1, 1))
        ways[:, position - begin] = poses
        return _costs(ways, turns, self._typical)

    def _exchange(self, t: int, temperature: float) -> None:
        """Let a pose change places with one of its socket, or stay."""
        in_socket = self.order == self.order[t]
        partners = np.flatnonzero(in_socket)
        numbers = np.arange(len(partners))
        chosen = np.tile(self.chosen, (len(partners), 1))
        chosen[numbers, partners] = self.chosen[t]
        chosen[:, t] = self.chosen[partners]
        ways = self.ways(chosen)
        cost = _costs(ways, np.zeros_like(ways[0, 1:]), self._typical)
        self.chosen = chosen[self._draw(cost, temperature)]

    def _draw(self, cost: np.ndarray, temperature: float) -> int:
        """Return one of some states, by their costs."""
        excess = cost - cost.min()
        sums = np.cumsum(np.exp(-excess / temperature))
        drawn = self.generator.uniform() * float(sums[-1])
        return int(np.searchsorted(sums, drawn))


def annealing(
    state: ParameterCovariance,
    where: Workspace,
    pools: Mapping[int, np.ndarray],
    order: Sequence[int],
    start: np.ndarray | None = None,
) -> Annealing:
    """Return the annealing of poses by a covariance so far; see :func:`plan_poses`."""
    of_pools = [state.whitened(pool, k) for k, pool in pools.items()]
    return Annealing(
        state.covariance,
        np.concatenate(of_pools),
        where.judged,
        pools,
        order,
        start,
    )


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
    return annealing(state, where, pools, order, start).way(before)

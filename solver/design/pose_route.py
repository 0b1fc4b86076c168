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

from .information import ParameterCovariance, Workspace, updated

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


def _costs(ways: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Return the costs of ways of shape (K, T, m), where another turns the joints as usual."""
    turned = np.abs(np.diff(ways, axis=1))
    total, most = turned.sum(axis=1), turned.max(axis=2)
    shares = 1.2 * total[:, 0] / usual[0] + total.max(axis=1) / usual.max()
    steps = np.maximum(most / LONG - 0.9, 0).sum(axis=1) + 2 * np.sqrt(most).mean(axis=1)
    return shares + total.sum(axis=1) / usual.sum() + steps


class Annealing:
    """State of the annealing: the chosen poses, and the covariance after them."""

    sweeps = SWEEPS
    slack = SLACK

    def __init__(
        self,
        prior: np.ndarray,
        rows: Mapping[int, np.ndarray],
        G: np.ndarray,
        pools: Mapping[int, np.ndarray],
        order: Sequence[int],
        start: np.ndarray | None,
    ) -> None:
        self.prior, self.rows, self.G = prior, rows, G
        self.pools, self.order, self.start = pools, list(order), start
        self.chosen = np.zeros(len(order), dtype=int)
        self.generator = np.random.default_rng(0)

    def greedy(self) -> None:
        """Choose the poses that teach most, one by one."""
        covariance = self.prior
        for t, k in enumerate(self.order):
            left = self._variances(covariance, self.rows[k])[1]
            self.chosen[t] = int(np.argmin(left))
            covariance = self.updated(covariance, self.rows[k][self.chosen[t]])

    def near(self, poses: np.ndarray) -> None:
        """Choose the poses of the pools that are nearest to some, in their order."""
        for t, (k, q) in enumerate(zip(self.order, poses, strict=False)):
            self.chosen[t] = int(np.argmin(np.abs(self.pools[k] - q).max(axis=1)))

    def poses(self, chosen: np.ndarray) -> np.ndarray:
        """Return ways, from the start on where it is known, shape (K, T, m)."""
        ways = np.stack([self.pools[k][chosen[:, t]] for t, k in enumerate(self.order)], axis=1)
        if self.start is None:
            return ways
        return np.concatenate([np.tile(self.start, (len(ways), 1, 1)), ways], axis=1)

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
        """Return covariances after a state: of samples with what is judged, of each, and of it."""
        cross = rows @ covariance
        return cross, cross @ rows.transpose(0, 2, 1) + np.eye(3), covariance

    def allowed(self) -> np.ndarray:
        """Return both mean variances that no way may exceed, by the chosen poses, shape (2,)."""
        covariance = self.seen(self.covariance(), next(iter(self.rows.values()))[:0])[2]
        return self.slack * np.einsum("gij,ji->g", self.G, covariance)

    def _variances(self, covariance: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return both mean variances after each of some samples, shape (2, N)."""
        cross, own, judged = self.seen(covariance, rows)
        S = np.linalg.inv(own)
        whole = np.einsum("gij,ji->g", self.G, judged)
        lowered = [
            np.sum(S * ((cross @ g) @ cross.transpose(0, 2, 1)), axis=(1, 2)) for g in self.G
        ]
        return whole[:, None] - np.array(lowered)

    def anneal(self, hot: float, sweeps: int, allowed: np.ndarray, usual: np.ndarray) -> None:
        """Draw each pose anew so many times, while it cools."""
        for temperature in np.geomspace(hot, COLD, sweeps):
            covariance = self.covariance()
            for t in map(int, self.generator.permutation(len(self.order))):
                k = self.order[t]
                rows = self.rows[k]
                without = self.updated(covariance, rows[self.chosen[t]], -1)
                some = self.generator.integers(len(rows), size=DRAWN)
                some[0] = self.chosen[t]
                ways = np.tile(self.chosen, (DRAWN, 1))
                ways[:, t] = some
                over = np.log(self._variances(without, rows[some]) / allowed[:, None]).clip(0)
                cost = _costs(self.poses(ways), usual) + HARD * over.sum(axis=0)
                self.chosen = ways[self._draw(cost, temperature)]
                covariance = self.updated(without, rows[self.chosen[t]])
                alike = np.flatnonzero(np.array(self.order) == k)
                ways = np.tile(self.chosen, (len(alike), 1))
                ways[:, t] = self.chosen[alike]
                ways[np.arange(len(alike)), alike] = self.chosen[t]
                self.chosen = ways[self._draw(_costs(self.poses(ways), usual), temperature)]

    def way(self, before: np.ndarray | None) -> np.ndarray:
        """Return the poses in their order, see :func:`plan_poses`, shape (T, m)."""
        self.greedy()
        allowed = self.allowed()
        usual = np.abs(np.diff(self.poses(self.chosen[None])[0], axis=0)).sum(axis=0).clip(1e-3)
        if before is None:
            self.anneal(HOT, self.sweeps, allowed, usual)
        else:
            self.near(before)
            self.anneal(WARM, AGAIN, allowed, usual)
        return self.poses(self.chosen[None])[0][-len(self.order) :]

    def _draw(self, cost: np.ndarray, temperature: float) -> int:
        """Return one of some states, by their costs."""
        sums = np.cumsum(np.exp((cost.min() - cost) / temperature))
        return int(np.searchsorted(sums, self.generator.uniform() * float(sums[-1])))


def plan_poses(
    known: ParameterCovariance,
    where: Workspace,
    pools: Mapping[int, np.ndarray],
    order: Sequence[int],
    start: np.ndarray | None = None,
    before: np.ndarray | None = None,
) -> np.ndarray:
    """Return poses for the samples to come, in their order, shape (T, m) [rad].

    Args:
        known: The covariance so far.
        where: Distances to be known.
        pools: For each socket in the order, poses that reach it, shape (N, m).
        order: The socket of each sample to come, T of them.
        start: The arm's pose now, shape (m,).
        before: A way that was returned before, of which this is the rest: only improved.
    """
    size, inner = len(known.covariance), known.model.size
    G = np.zeros((2, size, size))
    G[:, :inner, :inner] = where.mean, where.shape
    rows = {k: known.whitened(pools[k], k) for k in set(order)}
    return Annealing(known.covariance, rows, G, pools, order, start).way(before)

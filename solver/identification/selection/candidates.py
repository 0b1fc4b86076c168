"""What may differ between places, and the rise of the evidence by it, to first order."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

import numpy as np

from ..data import Clock, Observations
from ..inference import (
    Arrow,
    FitPosterior,
    NormalEquations,
    State,
    data_equations,
    prior_equations,
)
from ..model import (
    BALL,
    BASE,
    TYPICAL_SPREAD,
    Difference,
    courses_of_steps,
    directions,
)

WAVES = 8
"""Waves of a slow process at most: the k-th goes to and fro k / 2 times, and is k^2 times smaller
than the first, as those of a path whose speed is a random walk."""
EACH = 4
"""Samples for each wave."""
RUNS = range(2, 13)
"""Numbers of samples in a row after which a base may fall back."""
SIDE = 2
"""Fewest samples of a socket on either side of a step."""
MOST_STEPS = 200
"""Samples from which on a step is looked for, of a placement."""
MOST_OF_ALL = 1000
"""Steps of a ball or a joint that are looked for at most."""
BATCH = 100
"""Differences that are looked at together."""
ROWS = 500
"""Samples that are summed over together."""
FACTORS = np.exp(TYPICAL_SPREAD * np.arange(0, 4))
"""Widths that are tried, as factors of the usual one."""


def steps_of_base(
    data: Observations,
    placement: str,
    lengths: Iterable[float],
) -> list[Difference]:
    """Return the steps of a base that a placement's samples could tell, by their order.

    Each lasts for one of some numbers of samples; to the end where that is infinite. Of those that
    both orders have, as runs amid a socket, there is one.
    """
    rows = data.rows_of(placement)
    in_socket = data.sockets[rows] == np.unique(data.sockets[rows])[:, None]
    every_step = [
        Difference("step", (placement,), BASE, clock, at, at + length)
        for clock in orders(data, placement)
        for at, length in product(_starts(data, placement, clock), lengths)
    ]
    steps: dict[bytes, Difference] = {}
    for batch in _batches(every_step):
        courses = courses_of_steps(batch, data)[rows]
        counts = in_socket @ courses
        fewer = np.minimum(counts, in_socket.sum(1, keepdims=True) - counts)
        for k in np.flatnonzero(fewer.max(axis=0) >= SIDE).tolist():
            course = np.packbits(courses[:, k] > 0)
            steps.setdefault(course.tobytes(), batch[k])
    return [*steps.values()]


def _batches(differences: Sequence[Difference]) -> Iterator[Sequence[Difference]]:
    """Return differences in batches, whose courses fit into memory."""
    for begin in range(0, len(differences), BATCH):
        yield differences[begin : begin + BATCH]


def steps_of(data: Observations, part: str) -> list[Difference]:
    """Return the steps of a ball or a joint amid a placement, from which on it differs.

    They are in the order of the files alone: a large turn is not linear, and the reverse order
    would seem to gain by where it is linear.
    """
    steps: list[Difference] = []
    for begin, placement in enumerate(data.placements):
        on = data.placements[begin:]
        starts = _starts(data, placement, side=SIDE)
        steps += [Difference("step", on, part, at=at) for at in starts]
    return steps[:: 1 + len(steps) // MOST_OF_ALL]


def steps_between(data: Observations, part: str) -> list[Difference]:
    """Return the steps of a ball or a joint between placements, which some in a row have.

    The first has none: where it alone differs, all others have one.
    """
    placements = data.placements
    spans = combinations(range(1, len(placements) + 1), 2)
    steps = [Difference("step", placements[begin:end], part) for begin, end in spans]
    return steps[:: 1 + len(steps) // MOST_OF_ALL]


def _starts(
    data: Observations, placement: str, clock: Clock = "index", side: int = 1
) -> list[float]:
    """Return the samples of a placement from which on something may differ, evenly chosen.

    They are counted in one of its orders, with some left on either side.
    """
    t = data.clock(clock)[data.rows_of(placement), 0]
    ranks: np.ndarray = np.sort(t)[side : len(t) + 1 - side]
    if len(ranks) > MOST_STEPS:
        even = np.linspace(0, len(ranks) - 1, MOST_STEPS)
        ranks = ranks[even.astype(int)]
    return ranks.tolist()


def courses_of(data: Observations, placement: str) -> list[list[Difference]]:
    """Return the drifts of a base, and its slow processes, by its placement's clocks."""
    rows = data.rows_of(placement)
    waves = min(WAVES, int(rows.sum()) // EACH)
    if not waves:
        return []
    by_order = Difference("drift", (placement,))
    families: list[list[Difference]] = []
    clocks = orders(data, placement)
    for clock in ("time", "temperature"):
        if _runs(data, clock, placement):
            slow = replace(by_order, course="slow", clock=clock, waves=waves)
            families.append([slow])
    if _runs(data, "time", placement):
        clocks = ["time"]
    return [[replace(by_order, clock=clock) for clock in clocks], *families]


def orders(data: Observations, placement: str) -> list[Clock]:
    """Return the orders in which a placement may have been recorded.

    No time says of sockets one after the other, as in files of their own, which was the first.
    """
    rows = data.rows_of(placement)
    sockets = data.sockets[rows][np.argsort(data.clock("index")[rows, 0])]
    several = sockets[-1] > sockets[0] and (np.diff(sockets) >= 0).all()
    timed = np.isfinite(data.clock("time")[rows]).any()
    return ["index", "reverse"] if several and not timed else ["index"]


def follows_order(difference: Difference) -> bool:
    """Return True for what would be elsewhere by another order of recording."""
    return difference.at > 0 or difference.course == "drift"


def contradict(one: Difference, other: Difference) -> bool:
    """Return True for two that have the sockets of one placement in both orders."""
    both = follows_order(one) and follows_order(other)
    clocks = {one.clock, other.clock}
    same = one.placements[0] == other.placements[0]
    return both and same and clocks == {"index", "reverse"}


def _runs(data: Observations, clock: Clock, placement: str) -> bool:
    """Return True for a clock that is known of all samples of a placement, and runs."""
    t = data.clock(clock)[data.rows_of(placement), 0]
    return bool(np.isfinite(t).all() and np.ptp(t))


def set_ups(data: Observations) -> list[Difference]:
    """Return the targets of an instrument's placements, each of which is put on anew."""
    measured = dict.fromkeys(data.recorded_at[~data.seated].tolist())
    if len(measured) < 2:
        return []
    return [Difference("each", tuple(measured), BALL)]


@dataclass(frozen=True)
class Rises:
    """The rise of the evidence by further differences, to first order about a fit.

    With c_k the courses of K differences, D the derivatives of the errors by their unknowns u, V
    the information of the samples, and Sigma the covariance of all other unknowns,

        A = sum_i c_i^2 D_i^T V_i D_i       B = sum_i c_i D_i^T V_i J_i
        g = sum_i c_i w_i D_i^T C_i^-1 e_i + B d
        S = (A - B Sigma B^T + 1 / s^2)^-1
        (g^T S g + log |S| - log |s^2|) / 2

    at the most probable width s; d is the step that the fit itself would still take. All are sums
    over the samples that a difference concerns.
    """

    fit: FitPosterior

    @cached_property
    def state(self) -> State:
        """The fit's state with its samples' derivatives."""
        return self.fit.state.linearised()

    @cached_property
    def information(self) -> np.ndarray:
        """V, shape (N, 3, 3)."""
        state = self.state
        return state.information[:, None, None] * state.inverse_scales

    @cached_property
    def equations(self) -> NormalEquations:
        """L to second order about the fit."""
        state = self.state
        equations = data_equations(state) + prior_equations(state)
        return equations.tilted(state.linear.volume.slope)

    @cached_property
    def precision(self) -> Arrow:
        """Sigma^-1, of all unknowns of the fit."""
        return self.equations.arrow(self.state.free)

    @cached_property
    def change(self) -> np.ndarray:
        """The step d that the fit would still take, shape (n,)."""
        return -self.precision.inverse @ self.equations.g

    @cached_property
    def pulls(self) -> np.ndarray:
        """W C^-1 e, shape (N, 3, 1)."""
        state = self.state
        errors = state.errors[:, :, None]
        return state.weights[:, None, None] * state.inverse_scales @ errors

    def by(self, differences: Sequence[Difference]) -> np.ndarray:
        """Return the rise by each of K differences of one part, shape (K,)."""
        first, *others = differences
        fit = self.fit
        if not others:
            slopes = first.slopes(fit.model, fit.data)
            slopes *= np.repeat(first.weights, slopes.shape[2] // len(first.weights))
            return self._of(slopes, np.ones((len(slopes), 1)), first.width)
        slopes = directions(
            first.part, fit.model, fit.data, fit.model.values(fit.state.x)
        )
        courses = (
            courses_of_steps(batch, fit.data)
            if first.course == "step"
            else np.hstack([difference.courses(fit.data) for difference in batch])
            for batch in _batches(differences)
        )
        return np.concatenate([self._of(slopes, c, first.width) for c in courses])

    def _of(self, slopes: np.ndarray, courses: np.ndarray, usual: float) -> np.ndarray:
        """Return the rise by courses, shape (N, K), of directions whose usual width is given."""
        rows = np.flatnonzero(courses.any(axis=1) & slopes.any(axis=(1, 2)))
        if not len(rows):  # a ball on the last axis, say, which its joint does not move
            return -np.inf * np.ones(courses.shape[1])
        parts = np.array_split(rows, 1 + len(rows) // ROWS)
        sums = [np.zeros(())] * 3
        for part in parts:
            terms = self._sums(slopes[part], courses[part], part)
            sums = [a + b for a, b in zip(sums, terms, strict=True)]
        A, B, g = sums
        information = A - _spread(self.precision, B)
        towards: np.ndarray = B @ self.change
        g = g + towards
        values, axes = np.linalg.eigh(information)
        along = (axes.transpose(0, 2, 1) @ g[:, :, None])[:, :, 0]
        rises: list[np.ndarray] = []
        for factor in FACTORS.tolist():
            of_prior = (factor * usual) ** -2
            P = values.clip(min=0) + of_prior
            terms = along**2 / P - np.log(P / of_prior)
            spreads = np.log(factor) / TYPICAL_SPREAD
            rises.append(0.5 * (terms.sum(axis=1) - spreads**2))
        return np.max(rises, axis=0)

    def _sums(
        self, D: np.ndarray, c: np.ndarray, rows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A, B and g of some rows."""
        objective = self.fit.objective
        VD = self.information[rows] @ D
        B = np.zeros((c.shape[1], D.shape[2], objective.size))
        by_others = self.state.linear.by_unknowns[rows]
        B[:, :, : objective.dense] = _summed(c, VD, by_others)
        sockets = objective.data.sockets[rows]
        for k in np.unique(sockets[sockets >= 0]).tolist():
            seated = np.flatnonzero(sockets == k)
            of_centre = np.broadcast_to(-np.eye(3), (len(seated), 3, 3))
            B[:, :, objective.of_socket(k)] = _summed(c[seated], VD[seated], of_centre)
        g = _summed(c, D, self.pulls[rows])[:, :, 0]
        return _summed(c**2, D, VD), B, g


def _spread(precision: Arrow, B: np.ndarray) -> np.ndarray:
    """Return B_k Sigma B_k^T for K matrices, shape (K, d, n), as (K, d, d)."""
    root = B @ precision.root.T
    spread: np.ndarray = root @ root.transpose(0, 2, 1)
    for cell, R in precision.cells:
        of_cell = B[:, :, cell]
        if np.any(of_cell):
            root = of_cell @ R.T
            spread += root @ root.transpose(0, 2, 1)
    return spread


def _summed(c: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return sum_i c_ik X_i^T Y_i for K courses of R samples, X_i (3, d) and Y_i (3, e)."""
    if c.shape[1] == 1 and (c == 1).all():
        return np.tensordot(left, right, ((0, 1), (0, 1)))[None]
    products = left.transpose(0, 2, 1) @ right
    sums = c.T @ products.reshape(len(c), -1)
    return sums.reshape(-1, *products.shape[1:])

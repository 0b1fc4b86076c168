"""What may differ between places, and the rise of the evidence by it, to first order."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..data import Observations
from ..inference import FitPosterior, curvature, inverse_of_free
from ..model import BALL, TYPICAL_SPREAD, Difference, directions

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
FACTORS = np.exp(TYPICAL_SPREAD * np.arange(0, 4))
"""Widths that are tried, as factors of the usual one."""


def steps_of_base(
    data: Observations,
    placement: str,
    lengths: Iterable[float],
) -> list[Difference]:
    """Return the steps of a base that a placement's samples could tell, by their order.

    Each lasts for one of some numbers of samples; to the end where that is infinite.
    """
    rows = data.rows_of(placement)
    in_socket = data.sockets[rows] == np.unique(data.sockets[rows])[:, None]
    steps: list[Difference] = []
    for at, length in product(_ranks(data, placement), lengths):
        step = Difference("step", (placement,), at=at, until=at + length)
        counts = in_socket @ step.courses(data)[rows, 0]
        if np.minimum(counts, in_socket.sum(1) - counts).max() >= SIDE:
            steps.append(step)
    return steps


def steps_of(data: Observations, part: str) -> list[Difference]:
    """Return the steps of a ball or a joint: from a sample on, or throughout some placements."""
    placements = data.placements
    steps: list[Difference] = []
    for begin, placement in enumerate(placements):
        for at in _ranks(data, placement)[SIDE - 1 : 1 - SIDE]:
            steps.append(Difference("step", placements[begin:], part, at=at))
        for end in range(begin + 1, len(placements) + 1):
            if end - begin < len(placements):
                steps.append(Difference("step", placements[begin:end], part))
    return steps[:: 1 + len(steps) // MOST_OF_ALL]


def _ranks(data: Observations, placement: str) -> list[float]:
    """Return the samples of a placement from which on something may differ, evenly chosen."""
    ranks = np.sort(data.index[data.rows_of(placement), 0])[1:]
    if len(ranks) > MOST_STEPS:
        even = np.linspace(0, len(ranks) - 1, MOST_STEPS)
        ranks = ranks[even.astype(int)]
    return ranks.tolist()


def courses_of(data: Observations, placement: str) -> list[Difference]:
    """Return the drifts and slow processes of a base, by its placement's clocks."""
    rows = data.rows_of(placement)
    waves = min(WAVES, int(rows.sum()) // EACH)
    if not waves:
        return []
    by_order = Difference("drift", (placement,))
    slow: list[Difference] = []
    for clock in ("time", "temperature"):
        if _runs(data.clock(clock)[rows, 0]):
            slow.append(replace(by_order, course="slow", clock=clock, waves=waves))
    is_timed = any(course.clock == "time" for course in slow)
    drift = replace(by_order, clock="time") if is_timed else by_order
    return [drift, *slow]


def _runs(t: np.ndarray) -> bool:
    """Return True for a clock that is known of all samples, and runs."""
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
        g = sum_i c_i w_i D_i^T C_i^-1 e_i
        S = (A - B Sigma B^T + 1 / s^2)^-1
        (g^T S g + log |S| - log |s^2|) / 2

    at the most probable width s. All are sums over the samples that a difference concerns.
    """

    fit: FitPosterior

    @cached_property
    def information(self) -> np.ndarray:
        """V, shape (N, 3, 3)."""
        state = self.fit.state
        return state.information[:, None, None] * state.inverse_scales

    @cached_property
    def Sigma(self) -> np.ndarray:
        """Covariance of all unknowns of the fit, shape (n, n)."""
        state = self.fit.state
        precision = curvature(state, self.information) + state.prior_precision()
        return inverse_of_free(precision, state.free)

    @cached_property
    def pulls(self) -> np.ndarray:
        """W C^-1 e, shape (N, 3, 1)."""
        state = self.fit.state
        errors = state.errors[:, :, None]
        return state.weights[:, None, None] * state.inverse_scales @ errors

    def by(self, differences: Sequence[Difference]) -> np.ndarray:
        """Return the rise by each of K differences of one part, shape (K,)."""
        first, *others = differences
        fit = self.fit
        if others:
            slopes = directions(first.part, fit.model, fit.data, fit.arm.values)
            courses = np.concatenate([d.courses(fit.data) for d in differences], axis=1)
        else:
            slopes = first.slopes(fit.model, fit.data)
            slopes *= np.repeat(first.weights, slopes.shape[2] // len(first.weights))
            courses = np.ones((len(slopes), 1))
        rows = np.flatnonzero(courses.any(axis=1) & slopes.any(axis=(1, 2)))
        if not len(rows):  # a ball on the last axis, say, which its joint does not move
            return np.full(courses.shape[1], -np.inf)
        return self._of(-slopes[rows], courses[rows], rows, first.width)

    def _of(
        self,
        D: np.ndarray,
        c: np.ndarray,
        rows: np.ndarray,
        usual: float,
    ) -> np.ndarray:
        """Return the rise by courses c, shape (R, K), of some rows, whose usual width is given."""
        count, d = len(D), D.shape[2]
        D_T = D.transpose(0, 2, 1)
        DV = D_T @ self.information[rows]
        J = self.fit.state.linear.by_unknowns[rows]
        A = (c**2).T @ (DV @ D).reshape(count, -1)
        B = (c.T @ (DV @ J).reshape(count, -1)).reshape(-1, d, J.shape[2])
        g = c.T @ (D_T @ self.pulls[rows])[:, :, 0]
        information = A.reshape(-1, d, d) - B @ self.Sigma @ B.transpose(0, 2, 1)
        values, axes = np.linalg.eigh(information)
        along = (axes.transpose(0, 2, 1) @ g[:, :, None])[:, :, 0]
        best = np.full(len(g), -np.inf)
        for factor in FACTORS.tolist():
            of_prior = (factor * usual) ** -2
            P = values.clip(min=0) + of_prior
            rises = along**2 / P - np.log(P / of_prior)
            spreads = np.log(factor) / TYPICAL_SPREAD
            best = np.maximum(best, 0.5 * (rises.sum(axis=1) - spreads**2))
        return best

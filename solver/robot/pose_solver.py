"""Inverse kinematics: joint positions that put a tool at poses, many poses at a time."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from .pose_model import MAX_STEP, Goal, NewtonStep, PoseModel, limited_step, newton_step
from .row_function import RowFunction

TOLERANCE = 1e-9
"""A pose is reached where the residual is smaller [m, rad]."""
SETTLED = 1e-3
"""A smaller step toward the preferred posture is the last one [rad]."""
LAST = 3e-6
"""A smaller step is the last one if it would bring the residual within a thirtieth of the
tolerance, were it to shrink that as much as the step before did [rad]."""
ROUNDS = 60
STUCK, NEAR = 12, 1e-5
"""So many rounds that do not halve the residual end a search, once its square is less than NEAR: at
a singular configuration, or where a limit is in the way."""
AWAY, MARGIN = 3, 2.0
"""In the first of these rounds joints keep a distance from their limits, this multiple of the root
of the residual: an arm that is singular at a limit reaches a pose near it by way of others."""
FREE_STEPS = 5
"""Steps that bring one pose from a start nearby to TOLERANCE, without anything else in the way."""
SHORTEST = 0.3
"""In the other rounds, the least share of a step that is taken, see :func:`_relaxed`."""
TINY = 1e-300
"""Keeps divisors from zero."""
STILL = 1e-3
"""A step that is smaller relative to the residual ends a search, too [rad/m]."""
STARTS = 8
"""New starts for a pose at a time; the solution nearest to its first start is taken."""
SPREADS = (0.3, 0.6, 1.2, *[np.inf] * 13)
"""Standard deviations of these starts, one time after the other [rad]; infinite for the whole range
of the joints."""
ZERO = np.zeros(1)
"""Distance that joints keep from their limits where no search is stuck."""
NO_TOOL = np.eye(4)[:3].ravel()


@dataclass(frozen=True)
class Solutions:
    """Joint positions for N poses, and their residuals."""

    positions: np.ndarray
    """Shape (N, m) [rad]."""
    left: np.ndarray
    """Residual distance [m] and angle [rad], shape (N, 2)."""
    rounds: np.ndarray
    """Steps taken, shape (N,)."""

    @property
    def reached(self) -> np.ndarray:
        """True where the pose is reached, shape (N,)."""
        return self.left.max(axis=1) < TOLERANCE


class PoseSolver:
    """Solves for joint positions of one robot, for goals of a tool on a joint's child link.

    The limits are the least and largest positions of the joints, each of shape (m,) [rad]. Of a
    model whose residual does not shrink evenly, ``last`` is 0: each step is then measured.
    """

    def __init__(
        self,
        model: PoseModel,
        joint: int,
        limits: tuple[np.ndarray, np.ndarray],
        goal: Goal = "pose",
        last: float = LAST,
    ) -> None:
        self._goal: Goal = goal
        self._last = last
        self._model, self._joint = model, joint
        self.lower, self.upper = limits

    def solve(
        self,
        targets: np.ndarray,
        near: np.ndarray,
        prefer: np.ndarray | None = None,
        tool: np.ndarray = NO_TOOL,
    ) -> Solutions:
        """Return joint positions for poses, from one start each.

        Args:
            targets: Poses of the tool, the rows of [R | p], shape (N, 12).
            near: Joint positions to start from, shape (N, m) [rad].
            prefer: Posture to stay near where the pose leaves a choice, shape (N, m); None for the
                start.
            tool: Pose of the tool on the link, the rows of [R | p], shape (12,).
        """
        N, m = len(near), len(self.lower)
        q = np.clip(near, self.lower, self.upper)
        if N == 1:
            parts = (q, targets, q if prefer is None else prefer)
            solution = self._after_free_steps(np.concatenate(parts, axis=1), tool)
            if solution.left.max() < TOLERANCE:
                return solution
        found = Solutions(q, np.full((N, 2), np.inf), np.zeros(N, dtype=int))
        # A row holds q, target, prefer; the best q, and the step before; its residual, and the
        # square of that. Columns are contiguous, since these are computed with.
        parts = (q, targets, q if prefer is None else prefer, q, q, np.full((N, 3), np.inf))
        table, end = np.asfortranarray(np.hstack(parts)), 2 * m + 12
        moving, stuck = np.arange(N), np.zeros(N, dtype=int)
        for round_ in range(ROUNDS):
            rows, q, best = table[:, :end], table[:, :m], table[:, end : end + m]
            before, least, total = table[:, end + m : -3], table[:, -3:-1], table[:, -1]
            held = (stuck > 0) & (stuck <= AWAY)
            away = np.where(held, MARGIN * np.sqrt(np.sqrt(total)), 0.0) if held.any() else ZERO
            left, change, longest = self._step(rows, tool, away[:, None])
            settled, most = longest < SETTLED, np.maximum(left[:, 0], left[:, 1])
            now = np.square(left) @ np.ones(2)
            shrinks = np.sqrt(now / np.maximum(total, TINY))
            there = settled & (most < TOLERANCE)
            last = (longest < self._last) & (most * shrinks < TOLERANCE / 30) & (round_ > 0)
            better = (there | last | (now <= total))[:, None]
            stuck = np.where((now < total / 4) | (total > NEAR), 0, stuck + 1)
            stuck[longest < STILL * most] = STUCK
            np.copyto(best, q, where=better)
            np.copyto(least, left, where=better)
            np.add(best, change, out=best, where=last[:, None])
            np.multiply(least, shrinks[:, None], out=least, where=last[:, None])
            np.fmin(now, total, out=total)
            q += _relaxed(change, before, stuck > AWAY)
            before[:] = change
            np.copyto(rows[:, m + 12 :], q, where=settled[:, None])
            stay = ~(there | last) & (stuck < STUCK) & (round_ < ROUNDS - 1)
            if not stay.all():
                gone = ~stay
                at = moving[gone]
                found.positions[at], found.left[at] = best[gone], least[gone]
                found.rounds[at] = round_ + (last & ~there)[gone]
                moving, stuck, table = moving[stay], stuck[stay], table.T.compress(stay, axis=1).T
            if not moving.size:
                break
        return found

    def search(
        self,
        targets: np.ndarray,
        near: np.ndarray,
        prefer: np.ndarray | None = None,
        tool: np.ndarray = NO_TOOL,
    ) -> Solutions:
        """Return what :meth:`solve` does, with new starts where the first one leads nowhere.

        Of several solutions the nearest to the first start is taken.
        """
        found = self.solve(targets, near, prefer, tool)
        if found.reached.all():
            return found
        generator = np.random.default_rng(0)
        for spread in SPREADS:
            missing = np.flatnonzero(~found.reached)
            if not missing.size:
                break
            rows = np.repeat(missing, STARTS)
            starts = self._starts(near[rows], spread, generator)
            again = self.solve(
                targets[rows], starts, None if prefer is None else prefer[rows], tool
            )
            far: np.ndarray = np.linalg.norm(again.positions - near[rows], axis=1)
            left: np.ndarray = again.left.sum(axis=1)
            # the nearest that is reached; where none is, what leaves least
            rank = np.where(again.reached, far, 1e3 + left)
            rank = np.where(left > found.left[rows].sum(axis=1), np.inf, rank)
            chosen = rank.reshape(-1, STARTS).argmin(axis=1) + STARTS * np.arange(len(missing))
            some = np.isfinite(rank[chosen])
            into, chosen = missing[some], chosen[some]
            found.positions[into], found.left[into] = again.positions[chosen], again.left[chosen]
            found.rounds[into] += again.rounds[chosen]
        return found

    def _starts(
        self, near: np.ndarray, spread: float, generator: np.random.Generator
    ) -> np.ndarray:
        """Return starts within the limits; of endless joints, within a turn."""
        if np.isfinite(spread):
            return near + generator.normal(0, spread, near.shape)
        wide = self.upper - self.lower > 2 * np.pi
        lower = np.where(wide, np.maximum(self.lower, near - np.pi), self.lower)
        upper = np.where(wide, np.minimum(self.upper, near + np.pi), self.upper)
        return generator.uniform(lower, upper)

    def _after_free_steps(self, row: np.ndarray, tool: np.ndarray) -> Solutions:
        """Return where the steps of a row of q, target and prefer lead, if no limit is in the way.

        Of a single row, NumPy would take ten times as long for all that stands around the steps.
        """
        [state] = self._free_steps(np.concatenate((row[0], tool, np.zeros(3)))[None])
        left = np.inf if state[0, -1] else state[:, -3:-1]
        rounds = np.array([FREE_STEPS])
        return Solutions(state[:, : len(self.lower)], np.full((1, 2), left), rounds)

    @cached_property
    def _free_steps(self) -> RowFunction:
        """FREE_STEPS steps of a row: q, target, prefer, tool, what was left, and 1 if stopped."""
        step, inputs = self._expressions
        q, target, prefer, tool = (step.symbols[k] for k in ("q", "target", "prefer", "tool"))
        after, longest, stopped = q + step.change, ca.norm_inf(step.change), ca.SX.sym("stopped")
        beyond = ca.mmax(ca.vertcat(self.lower - after, after - self.upper, longest - MAX_STEP))
        state = ca.vertcat(inputs, tool, ca.SX.sym("left", 2), stopped)
        posture = ca.if_else(longest < SETTLED, after, prefer)
        stops = ca.fmax(stopped, beyond > 0)
        outputs = ca.vertcat(after, target, posture, tool, step.left, stops)
        return RowFunction("steps", [state.T], [outputs], FREE_STEPS)

    def _step(
        self, rows: np.ndarray, tool: np.ndarray, away: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return residuals at q, steps, and the largest change of a joint in each step."""
        m = len(self.lower)
        left, change, model = self._free(rows, tool)
        after, lower, upper = rows[:, :m] + change, self.lower + away, self.upper - away
        longest = np.abs(change).max(axis=1, initial=0)
        outside = ((after < lower) | (after > upper)).any(axis=1) | ~(longest <= MAX_STEP)
        if outside.any():
            bounds = (np.broadcast_to(bound, after.shape) for bound in (lower, upper))
            known = [values[outside] for values in (rows, change, model, *bounds)]
            [change[outside]] = self._limited(np.hstack(known))
            longest[outside] = np.abs(change[outside]).max(axis=1, initial=0)
        return left, change, longest

    @cached_property
    def _free(self) -> RowFunction:
        step, inputs = self._expressions
        model = ca.vertcat(step.error, ca.vec(step.jacobian))
        outputs = [step.left, step.change, model]
        return RowFunction("step", [step.symbols["tool"], inputs], outputs)

    @cached_property
    def _limited(self) -> RowFunction:
        step, inputs = self._expressions
        names = ("error", "jacobian", "change")
        known = {name: ca.SX.sym(name, *getattr(step, name).shape) for name in names}
        lower, upper = (ca.SX.sym(name, len(self.lower)) for name in ("lower", "upper"))
        values = (*(known[name] for name in ("change", *names[:2])), lower, upper)
        change = limited_step(replace(step, **known), lower, upper)
        return RowFunction("limited", [ca.vertcat(inputs, *map(ca.vec, values))], [change])

    @cached_property
    def _expressions(self) -> tuple[NewtonStep, Any]:
        """Expressions of a step, and its row of inputs."""
        step = newton_step(self._model, self._joint, self._goal)
        return step, ca.vertcat(*(step.symbols[name] for name in ("q", "target", "prefer")))


def _relaxed(change: np.ndarray, before: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """Return the steps, shorter where they alternate in sign (Aitken's relaxation)."""
    if not slow.any():
        return change
    scale, d = np.ones((len(change), 1)), change[slow] - before[slow]
    moves = (change[slow] * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), TINY)
    scale[slow, 0] = (1 - moves).clip(SHORTEST, 1)
    return change * scale

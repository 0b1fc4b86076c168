"""Inverse kinematics: joint positions that put a tool at poses, many poses at a time."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ..identification.robot import RowFunction
from .pose_model import MAX_STEP, Goal, NewtonStep, PoseModel, limited_step, newton_step
from .pose_search import SETTLED, STUCK, Searches, SearchStep

TOLERANCE = 1e-9
"""A pose is reached where the residual is smaller [m, rad]."""
LAST = 3e-6
"""A smaller step is the last one if it would bring the residual within a thirtieth of the
tolerance, were it to shrink that as much as the step before did [rad]."""
ROUNDS = 60
FREE_STEPS = 5
"""Steps that bring one pose from a start nearby to TOLERANCE, without anything else in the way."""
STARTS = 8
"""New starts for a pose at a time; the solution nearest to its first start is taken."""
SPREADS = (0.3, 0.6, 1.2, *[np.inf] * 13)
"""Standard deviations of these starts, one time after the other [rad]; infinite for the whole range
of the joints."""
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

    @property
    def remainder(self) -> np.ndarray:
        """Sum of the residual distance [m] and angle [rad], shape (N,)."""
        return self.left.sum(axis=1)

    def improve(
        self,
        poses: np.ndarray,
        retries: "Solutions",
        rank: np.ndarray,
    ) -> None:
        """Take over the retry of least finite rank for each of some poses, STARTS a pose."""
        best = rank.reshape(-1, STARTS).argmin(axis=1)
        winners = best + STARTS * np.arange(len(poses))
        some = np.isfinite(rank[winners])
        winners = winners[some]
        into = poses[some]
        self.positions[into] = retries.positions[winners]
        self.left[into] = retries.left[winners]
        self.rounds[into] += retries.rounds[winners]


@dataclass(eq=False)
class PoseSolver:
    """Solves for joint positions of one robot, for goals of a tool on a joint's child link."""

    model: PoseModel
    joint: int
    limits: tuple[np.ndarray, np.ndarray]
    """Least and largest positions of the joints, each of shape (m,) [rad]."""
    goal: Goal = "pose"
    last: float = LAST
    """0 for a model whose residual does not shrink evenly: each step is then measured."""

    def __post_init__(self) -> None:
        self.lower, self.upper = self.limits

    def solve(
        self,
        targets: np.ndarray,
        start: np.ndarray,
        prefer: np.ndarray | None = None,
        tool: np.ndarray = NO_TOOL,
    ) -> Solutions:
        """Return joint positions for poses, from one start each.

        Args:
            targets: Poses of the tool, the rows of [R | p], shape (N, 12).
            start: Joint positions to start from, shape (N, m) [rad].
            prefer: Posture to stay near where the pose leaves a choice, shape (N, m); None for the
                start.
            tool: Pose of the tool on the link, the rows of [R | p], shape (12,).
        """
        q = np.clip(start, self.lower, self.upper)
        prefer = q if prefer is None else prefer
        if len(q) == 1:
            row = np.concatenate((q, targets, prefer), axis=1)
            solution = self._after_free_steps(row, tool)
            if solution.left.max() < TOLERANCE:
                return solution
        return self._after_bounded_steps(q, targets, prefer, tool)

    def _after_bounded_steps(
        self,
        q: np.ndarray,
        targets: np.ndarray,
        prefer: np.ndarray,
        tool: np.ndarray,
    ) -> Solutions:
        """Return solutions by steps that keep the limits, from starts within these."""
        residuals = np.full((len(q), 2), np.inf)
        solutions = Solutions(q, residuals, np.zeros(len(q), dtype=int))
        searches = Searches.begun(q, targets, prefer)
        for count in range(ROUNDS):
            step = self._step(searches, tool)
            arrived = step.settled & (step.largest < TOLERANCE)
            shrinkage = searches.shrinkage(step)
            promise = step.largest * shrinkage
            small = (step.longest < self.last) & (promise < TOLERANCE / 30)
            last = small & (count > 0)
            searches.keep(step, arrived | last)
            if last.any():  # without a look at what they leave: it shrinks as before
                searches.best[last] += step.change[last]
                searches.residual[last] *= shrinkage[last, None]
            searches.move(step)
            stuck = searches.stalls >= STUCK
            ends = arrived | last | stuck | (count == ROUNDS - 1)
            if ends.any():
                poses = searches.pose[ends]
                rounds = count + (last & ~arrived)
                solutions.positions[poses] = searches.best[ends]
                solutions.left[poses] = searches.residual[ends]
                solutions.rounds[poses] = rounds[ends]
                if ends.all():
                    break
                searches = searches.where(~ends)
        return solutions

    def search(
        self,
        targets: np.ndarray,
        start: np.ndarray,
        prefer: np.ndarray | None = None,
        tool: np.ndarray = NO_TOOL,
    ) -> Solutions:
        """Return what :meth:`solve` does, with new starts where the first one leads nowhere.

        Of several solutions the nearest to the first start is taken.
        """
        solutions = self.solve(targets, start, prefer, tool)
        if solutions.reached.all():
            return solutions
        generator = np.random.default_rng(0)
        for spread in SPREADS:
            failures = np.flatnonzero(~solutions.reached)
            if not failures.size:
                break
            rows = np.repeat(failures, STARTS)
            starts = self._starts(start[rows], spread, generator)
            postures = None if prefer is None else prefer[rows]
            retries = self.solve(targets[rows], starts, postures, tool)
            # ranks, shape (N,): the nearest that is reached; where none is, what
            # leaves least
            distance = np.linalg.norm(retries.positions - start[rows], axis=1)
            rank = np.where(retries.reached, distance, 1e3 + retries.remainder)
            worse = retries.remainder > solutions.remainder[rows]
            rank[worse] = np.inf
            solutions.improve(failures, retries, rank)
        return solutions

    def _starts(
        self,
        centre: np.ndarray,
        spread: float,
        generator: np.random.Generator,
    ) -> np.ndarray:
        """Return starts within the limits; of endless joints, within a turn."""
        if np.isfinite(spread):
            return centre + generator.normal(0, spread, centre.shape)
        wide = self.upper - self.lower > 2 * np.pi
        lower = np.where(wide, np.maximum(self.lower, centre - np.pi), self.lower)
        upper = np.where(wide, np.minimum(self.upper, centre + np.pi), self.upper)
        return generator.uniform(lower, upper)

    def _after_free_steps(
        self,
        row: np.ndarray,
        tool: np.ndarray,
    ) -> Solutions:
        """Return where the steps of a row of q, target and prefer lead, if no limit is in the way.

        Of a single row, NumPy would take ten times as long for all that stands around the steps.
        """
        state = np.concatenate((row[0], tool, np.zeros(3)))
        [after] = self._free_steps(state[None])
        stopped = after[0, -1]
        remainder = np.inf if stopped else after[:, -3:-1]
        return Solutions(
            positions=after[:, : len(self.lower)],
            left=np.full((1, 2), remainder),
            rounds=np.array([FREE_STEPS]),
        )

    @cached_property
    def _free_steps(self) -> RowFunction:
        """FREE_STEPS steps of a row: q, target, prefer, tool, what was left, and 1 if stopped."""
        step, inputs = self._expressions
        symbols = step.symbols
        tool = symbols["tool"]
        stopped = ca.SX.sym("stopped")
        state = ca.vertcat(inputs, tool, ca.SX.sym("left", 2), stopped)
        after = symbols["q"] + step.change
        longest = ca.norm_inf(step.change)
        excess = ca.vertcat(self.lower - after, after - self.upper, longest - MAX_STEP)
        stops = ca.fmax(stopped, ca.mmax(excess) > 0)
        posture = ca.if_else(longest < SETTLED, after, symbols["prefer"])
        next_state = ca.vertcat(
            after, symbols["target"], posture, tool, step.left, stops
        )
        return RowFunction("steps", [state.T], [next_state], FREE_STEPS)

    def _step(
        self,
        searches: Searches,
        tool: np.ndarray,
    ) -> SearchStep:
        """Return the steps of searches, within the limits."""
        rows = searches.rows
        margins = searches.margins
        remainder, change, model = self._free(rows, tool)
        after = searches.q + change
        lower = self.lower + margins
        upper = self.upper - margins
        longest = np.abs(change).max(axis=1, initial=0)
        beyond = (after < lower) | (after > upper)
        outside = beyond.any(axis=1) | ~(longest <= MAX_STEP)
        if outside.any():
            bounds = np.broadcast_arrays(lower, upper, after)[:2]
            columns = [values[outside] for values in (rows, change, model, *bounds)]
            [limited] = self._limited(np.hstack(columns))
            change[outside] = limited
            longest[outside] = np.abs(limited).max(axis=1, initial=0)
        return SearchStep(remainder, change, longest)

    @cached_property
    def _free(self) -> RowFunction:
        """Distance and angle left, the step without limits, and its model, of a row of inputs."""
        step, inputs = self._expressions
        model = ca.vertcat(step.error, ca.vec(step.jacobian))
        outputs = [step.left, step.change, model]
        return RowFunction("step", [step.symbols["tool"], inputs], outputs)

    @cached_property
    def _limited(self) -> RowFunction:
        """The step within limits, of a row of inputs, the free step, its model, and limits."""
        step, inputs = self._expressions
        change = ca.SX.sym("change", *step.change.shape)
        error = ca.SX.sym("error", *step.error.shape)
        jacobian = ca.SX.sym("jacobian", *step.jacobian.shape)
        lower = ca.SX.sym("lower", len(self.lower))
        upper = ca.SX.sym("upper", len(self.lower))
        free = replace(step, change=change, error=error, jacobian=jacobian)
        row = ca.vertcat(inputs, change, error, ca.vec(jacobian), lower, upper)
        return RowFunction("limited", [row], [limited_step(free, lower, upper)])

    @cached_property
    def _expressions(self) -> tuple[NewtonStep, Any]:
        """Expressions of a step, and its row of inputs."""
        step = newton_step(self.model, self.joint, self.goal)
        symbols = step.symbols
        inputs = ca.vertcat(symbols["q"], symbols["target"], symbols["prefer"])
        return step, inputs

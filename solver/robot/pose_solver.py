"""Inverse kinematics: joint positions at which a tool stands at poses, many poses at a time."""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from .newton import MAX_STEP, Goal, newton_step
from .pose_model import PoseModel
from .row_function import ColumnFunction

TOLERANCE = 1e-10
"""A pose is reached where no more is left [m, rad]."""
SETTLED = 1e-3
"""A smaller step toward the preferred posture is the last one [rad]."""
ROUNDS = 60
STUCK, NEAR = 20, 1e-5
"""Near a pose, by the square of what is left, so many rounds that do not halve what is left end a
search: the joints fold there, or a limit is in the way."""
STILL = 1e-3
"""A step so small beside what is left ends it too: it leads nowhere [rad/m]."""
STARTS = 8
"""New starts of a pose at a time, among which the nearest solution is taken."""
SPREADS = (0.3, 0.6, 1.2, *[np.inf] * 13)
"""Standard deviation of these starts, time after time [rad]; infinite for all of the range."""
NO_TOOL = np.eye(4)[:3].ravel()


@dataclass(frozen=True)
class Solutions:
    """Joint positions for N poses, and how near they come to them."""

    positions: np.ndarray
    """Shape (N, m) [rad]."""
    left: np.ndarray
    """Distance [m] and angle [rad] left, shape (N, 2)."""
    rounds: np.ndarray
    """Steps taken, shape (N,)."""

    @property
    def reached(self) -> np.ndarray:
        """True where the pose is reached, shape (N,)."""
        return self.left.max(axis=1) < TOLERANCE


class PoseSolver:
    """Solves for joint positions of one robot.

    Args:
        model: The robot's.
        joint: Index of the chain's joint whose child link carries the tool.
        limits: Least and largest positions of the joints, each of shape (m,) [rad].
        goal: What of a pose counts.
    """

    def __init__(
        self,
        model: PoseModel,
        joint: int,
        limits: tuple[np.ndarray, np.ndarray],
        goal: Goal = "pose",
    ) -> None:
        self._goal: Goal = goal
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
        rows = np.concatenate([q, targets, q if prefer is None else prefer], axis=1)
        rows = np.asfortranarray(rows)  # whose columns are computed with
        best, least, rounds = q, np.full((N, 2), np.inf), np.zeros(N, dtype=int)
        moving, total, stuck = np.arange(N), np.full(N, np.inf), np.zeros(N, dtype=int)
        for _ in range(ROUNDS):
            left, change, longest = self._step(rows, tool)
            settled, most = longest < SETTLED, left.max(axis=1)
            done = settled & (most < TOLERANCE)
            now = np.square(left) @ np.ones(2)
            better = done | (now <= total)
            stuck = np.where((now < total / 4) | (total > NEAR), 0, stuck + 1)
            stuck[longest < STILL * most] = STUCK
            best[moving[better]], least[moving[better]] = rows[better, :m], left[better]
            total = np.fmin(now, total)
            rows[:, :m] += change
            np.copyto(rows[:, m + 12 :], rows[:, :m], where=settled[:, None])
            stay = ~done & (stuck < STUCK)
            if not stay.all():
                moving, total, stuck = moving[stay], total[stay], stuck[stay]
                rows = np.compress(stay, rows.T, axis=1).T
            if not moving.size:
                break
            rounds[moving] += 1
        return Solutions(best, least, rounds)

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

    def _step(
        self, rows: np.ndarray, tool: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what is left at q, the step, and its longest; limits cost rows that meet them."""
        m = len(self.lower)
        left, change = self._free(rows, tool)
        after = rows[:, :m] + change
        longest = np.abs(change).max(axis=1, initial=0)
        outside = ((after < self.lower) | (after > self.upper)).any(axis=1)
        outside |= ~(longest <= MAX_STEP)
        if outside.any():
            change[outside] = self._limited(rows[outside], tool, self.lower, self.upper)[1]
            longest[outside] = np.abs(change[outside]).max(axis=1, initial=0)
        return left, change, longest

    @cached_property
    def _free(self) -> ColumnFunction:
        return self._function("tool")

    @cached_property
    def _limited(self) -> ColumnFunction:
        return self._function("tool", "lower", "upper")

    def _function(self, *shared: str) -> ColumnFunction:
        step = newton_step(self._model, self._joint, self._goal, limited="lower" in shared)
        row = ca.vertcat(*(step.symbols[name] for name in ("q", "target", "prefer")))
        return ColumnFunction(
            "step", [*(step.symbols[name] for name in shared), row], [step.left, step.change]
        )

"""Joint positions along poses, and the refusal of poses that are not reached."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MukcaError
from ..poses import Solutions

DETOUR = (0.02, 0.1)
"""Neighbours are joined where half way between them the tool is this far off the way at most, and
half the way itself [m], [rad]."""
FAR = 20.0
"""No arm is this large [m]."""
BEYOND = 0.1
"""Distance left [m] from which a pose is out of the arm's reach, not only of the start."""


class CommandError(MukcaError):
    """A pose that no joint positions within the limits reach, as far as was found."""

    def __init__(
        self, message: str, solutions: Solutions, row: int, joint: str = ""
    ) -> None:
        super().__init__(message)
        self.positions: np.ndarray = solutions.positions[row]
        """The nearest joint positions, shape (m,) [rad]."""
        self.left: np.ndarray = solutions.left[row]
        """Distance [m] and angle [rad] that are left there, shape (2,)."""
        self.joint = joint
        """The joint that stands at its limit there; empty for none."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to other processes, of which those of a pool wait for good otherwise."""
        nearest = Solutions(self.positions[None], self.left[None], np.zeros(1, int))
        return CommandError, (*self.args, nearest, 0, self.joint)


@dataclass(frozen=True, repr=False)
class JointPath(Solutions):
    """Joint positions for N poses, each near those before."""

    joint_names: tuple[str, ...]
    at_limit: tuple[str, ...]
    """The joint that stands at its limit, pose by pose; empty for none."""
    singular_value: np.ndarray
    """Smallest singular value of the Jacobian, shape (N,): near 0, joints must turn fast."""
    jumps: tuple[int, ...]
    """Poses to which the joints cannot go straight from the pose before: the tool would leave the
    way."""

    def __repr__(self) -> str:
        at_limit = sum(map(bool, self.at_limit))
        return (
            f"JointPath({len(self.positions)} poses: {self.reached.sum()} reached, "
            f"{len(self.jumps)} jumps, {at_limit} with a joint at its limit)"
        )

    def checked(self) -> np.ndarray:
        """Return the positions, shape (N, m) [rad].

        Raises:
            CommandError: A pose is not reached, or the joints jump between two.
        """
        faults = [*np.flatnonzero(~self.reached).tolist(), *self.jumps]
        if not faults:
            return self.positions
        row = min(faults)
        joint = self.at_limit[row]
        if not self.reached[row]:
            raise not_reached(f"pose {row}", self, row, joint)
        words = (
            f"pose {row}: from the pose before the joints jump, and the tool would leave the way; "
            "start in another posture, or give poses between them"
        )
        raise CommandError(words, self, row, joint)


def along(
    search: Callable[..., Solutions],
    targets: np.ndarray,
    near: np.ndarray,
    prefer: ArrayLike,
) -> Solutions:
    """Return solutions for poses, each searched for near the last one that was reached."""
    if not len(targets):
        return search(targets, near, prefer)
    rows: list[tuple[np.ndarray, ...]] = []
    for target in targets:
        solution = search(target[None], near, prefer)
        near = solution.positions if solution.reached.all() else near
        rows.append((solution.positions, solution.left, solution.rounds))
    return Solutions(*map(np.concatenate, zip(*rows, strict=True)))


def reached_rows(solutions: Solutions) -> np.ndarray:
    """Return positions of a URDF that put its flange where the full model has it, shape (N, m).

    Where there are none the row is NaN, unless no row has any: that is refused.
    """
    reached = solutions.reached
    if reached.any() or not reached.size:
        return np.where(reached[:, None], solutions.positions, np.nan)
    raise CommandError(
        "no joint positions nearby put the URDF's flange where the full model has its flange. "
        f"{1e3 * solutions.left[0, 0]:.3g} mm and {1e3 * solutions.left[0, 1]:.3g} mrad are left: "
        "the arm is singular there, or has fewer than six joints",
        solutions,
        0,
    )


def check_within(
    solutions: Solutions, near: np.ndarray, within: float, joints: tuple[str, ...]
) -> None:
    """Refuse positions of another branch: a joint would turn farther than ``within`` [rad, m]."""
    ways = np.abs(solutions.positions - near)
    for row in np.flatnonzero(ways.max(axis=1, initial=0) > within)[:1].tolist():
        joint = joints[int(ways[row].argmax())]
        raise CommandError(
            f"pose {row}: only on another branch, by which {joint} would turn by "
            f"{ways[row].max():.3g} rad, beyond within={within:g}; give poses between them, or "
            "another near",
            solutions,
            row,
            joint,
        )


def not_reached(where: str, solutions: Solutions, row: int, joint: str) -> CommandError:
    """Return the error that says how far a pose is from being reached."""
    cure = "give a pose within reach, or start near another posture"
    residual = solutions.left[row]
    if residual[0] > BEYOND:
        cure = (
            "the pose is out of the arm's reach, its joints' limits kept: give one that is that "
            "much nearer; poses are those of the tool, or of the flange, in the base's frame"
        )
    if residual[0] > FAR:
        cure = "poses are in metres: is this one in millimetres?"
    return CommandError(
        f"{where}: not reached; at the nearest joint positions found "
        f"{1e3 * residual[0]:.6g} mm and {1e3 * residual[1]:.6g} mrad are left, "
        f"with {joint or 'no joint'} at its limit; {cure}",
        solutions,
        row,
        joint,
    )


def find_jumps(
    q: np.ndarray, pose: Callable[[np.ndarray], np.ndarray], turns: bool
) -> list[int]:
    """Return the rows to which the joints do not go straight, by the tool's way and its turns."""
    poses = pose(q)
    first, second = poses[:-1], poses[1:]
    between = pose((q[:-1] + q[1:]) / 2)
    jumps = np.zeros(len(first), dtype=bool)
    distances = (_distance, _angle) if turns else (_distance,)
    for distance, threshold in zip(distances, DETOUR, strict=False):
        direct = distance(first, second)
        detour = distance(first, between) + distance(between, second) - direct
        jumps |= detour > 2 * threshold + direct
    return (1 + np.flatnonzero(jumps)).tolist()


def _distance(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.linalg.norm(second[:, :3, 3] - first[:, :3, 3], axis=1)


def _angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    trace = np.einsum("nij,nij->n", first[:, :3, :3], second[:, :3, :3])
    return np.arccos(((trace - 1) / 2).clip(-1, 1))

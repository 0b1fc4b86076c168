"""Joint positions along poses, and the words for what is wrong with them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import MukcaError

DETOUR = (0.02, 0.1)
"""Neighbours are joined where half way between them the tool is this far off the way at most, and
half the way itself [m], [rad]."""


class CommandError(MukcaError):
    """A pose that no joint positions within the limits reach, as far as was found."""

    def __init__(self, message: str, positions: np.ndarray, left: np.ndarray, joint: str) -> None:
        super().__init__(message)
        self.positions = positions
        """The nearest joint positions, shape (m,) [rad]."""
        self.left = left
        """Distance [m] and angle [rad] that are left there, shape (2,)."""
        self.joint = joint
        """The joint that stands at its limit there; empty for none."""


@dataclass(frozen=True)
class JointPath:
    """Joint positions for N poses, each near those before."""

    joint_names: tuple[str, ...]
    positions: np.ndarray
    """Shape (N, m) [rad]; where a pose is not reached, the nearest that were found."""
    reached: np.ndarray
    """True where the tool stands at the pose, shape (N,)."""
    left: np.ndarray
    """Distance [m] and angle [rad] left, shape (N, 2)."""
    rounds: np.ndarray
    """Steps that it took, shape (N,)."""
    at_limit: tuple[str, ...]
    """The joint that stands at its limit, pose by pose; empty for none."""
    singular_value: np.ndarray
    """Smallest singular value of the Jacobian, shape (N,): near 0, joints must turn fast."""
    jumps: tuple[int, ...]
    """Poses to which the joints cannot go straight from the pose before: the tool would leave the
    way."""

    def checked(self, wheres: Sequence[str] | None = None) -> np.ndarray:
        """Return the positions, shape (N, m) [rad].

        Args:
            wheres: Name of each pose, for messages; None for its number.

        Raises:
            CommandError: A pose is not reached, or the joints jump between two.
        """
        wrong = [*np.flatnonzero(~self.reached).tolist(), *self.jumps]
        if wrong:
            row = min(wrong)
            where = f"pose {row}" if wheres is None else wheres[row]
            left, joint = self.left[row], self.at_limit[row]
            words = not_reached(where, left, joint)
            if self.reached[row]:
                words = (
                    f"{where}: from the pose before the joints jump, and the tool would leave the "
                    "way; start in another posture, or give poses between them"
                )
            raise CommandError(words, self.positions[row], left, joint)
        return self.positions


def not_reached(where: str, left: np.ndarray, joint: str) -> str:
    """Return the line that says how far a pose is from being reached."""
    return (
        f"{where}: not reached; at the nearest joint positions found {1e3 * left[0]:.4g} mm and "
        f"{1e3 * left[1]:.4g} mrad are left, with {joint or 'no joint'} at its limit; give a pose "
        "within reach, or start near another posture"
    )


def find_jumps(q: np.ndarray, pose: Callable[[np.ndarray], np.ndarray], turns: bool) -> list[int]:
    """Return the rows to which the joints do not go straight from the row before.

    Args:
        q: Joint positions, shape (N, m) [rad].
        pose: Poses of the tool, shape (N, 4, 4), at joint positions.
        turns: Tell by the tool's turns, too.
    """
    one, between, other = (pose(rows) for rows in (q[:-1], (q[:-1] + q[1:]) / 2, q[1:]))
    jumps = np.zeros(len(one), dtype=bool)
    for distance, least in list(zip((_distance, _angle), DETOUR, strict=True))[: 1 + turns]:
        direct = distance(one, other)
        detour = distance(one, between) + distance(between, other) - direct
        jumps |= detour > 2 * least + direct
    return (1 + np.flatnonzero(jumps)).tolist()


def _distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.linalg.norm(other[:, :3, 3] - one[:, :3, 3], axis=1)


def _angle(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    trace = np.einsum("nij,nij->n", one[:, :3, :3], other[:, :3, :3])
    return np.arccos(((trace - 1) / 2).clip(-1, 1))

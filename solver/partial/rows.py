"""Samples of an arm as two ways to one place, and their errors by all unknowns.

With F(q) the flange by the calibrated chain, U a tool or camera on it, and V a place in the base,

    F(q_i) U L_i = V_k(i) R_i

where L_i or R_i is what a camera or an instrument measured, and the other the identity. A tool's
tip in a socket has neither: U is the tip's place on the flange, and V the socket's centre. A camera
on the arm measures L_i, the board's pose; one beside the arm measures R_i. The errors are

    t_i = p(F U L) - p(V R)      r_i = log(rot(F U L) rot(V R)^T)

in the base's axes, and derivatives are by small turns about the axes of flange (U) and base (V).
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..bayes.model import ExtendedModel
from ..data import rotation_vectors
from ..robot import matrix_rpy


@dataclass(frozen=True)
class Rows:
    """Samples: joint positions, the place each belongs to, and poses that were measured."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    moments: np.ndarray
    """What holds the joints, shape (N, 3 m) [N m]."""
    places: np.ndarray
    """Index of each sample's place V, shape (N,)."""
    names: tuple[str, ...]
    """Of the places."""
    left: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    """L, shape (N, 4, 4); empty for the identity."""
    right: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    """R, likewise."""
    wheres: tuple[str, ...] = ()
    """File and line of each sample, for messages."""

    @property
    def turns(self) -> bool:
        """True where orientations were measured, too."""
        return len(self.left) + len(self.right) > 0

    @property
    def axes(self) -> int:
        """Number of errors of a sample, 3 or 6."""
        return 6 if self.turns else 3

    def measured(self) -> tuple[np.ndarray, np.ndarray]:
        """Return L and R, the identity written out, each of shape (N, 4, 4)."""
        ones = np.tile(np.eye(4), (len(self.q), 1, 1))
        return self.left if len(self.left) else ones, self.right if len(self.right) else ones


class Flanges(NamedTuple):
    """Poses of the flange, and their derivatives."""

    R: np.ndarray
    """Rotations, shape (N, 3, 3)."""
    p: np.ndarray
    """Shape (N, 3) [m]."""
    by_unknowns: np.ndarray
    """Derivatives of p, then turns, by the model's unknowns, the tool left out, (N, 6, size)."""
    by_joints: np.ndarray
    """The same by the joints' positions, as noisy as each is, shape (N, 6, m)."""


def flanges(
    model: ExtendedModel, ball: np.ndarray, x: np.ndarray, q: np.ndarray, moments: np.ndarray
) -> Flanges:
    """Return the flange's poses at joint positions: those of a ball in its origin."""
    at = x.copy()
    at[ball] = -model.ball.nominal[ball]
    p, *of_p = model.linearise(at, q, moments)
    R, *of_turns = model.linearise(at, q, moments, of_turns=True)
    by_unknowns, by_joints = (
        np.concatenate(both, axis=1) for both in zip(of_p, of_turns, strict=True)
    )
    by_unknowns[:, :, [i for i, p in enumerate(model.parameters) if p.of_ball]] = 0.0
    of_ball = matrix_rpy(model.ball.origins(model.values(at))[-1, 3:])
    return Flanges(R @ of_ball.T, p, by_unknowns, by_joints)


def linearise(
    rows: Rows, at: Flanges, ball: np.ndarray, tool: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Return errors [m], [rad], and their derivatives: unknowns, U's turn, places, joints.

    Each of shape (N, 3 or 6, ...): an orientation that was not measured has no error.
    """
    L, R = rows.measured()
    V = places[rows.places]
    arm = np.einsum("ij,nj->ni", tool[:3, :3], L[:, :3, 3])
    beyond = np.einsum("nij,nj->ni", at.R, arm + tool[:3, 3])
    reach = np.einsum("nij,nj->ni", V[:, :3, :3], R[:, :3, 3])
    turned = at.R @ tool[:3, :3] @ L[:, :3, :3]
    off = turned @ (V[:, :3, :3] @ R[:, :3, :3]).transpose(0, 2, 1)
    errors = np.concatenate([at.p + beyond - V[:, :3, 3] - reach, rotation_vectors(off)], axis=1)

    def moved(by: np.ndarray) -> np.ndarray:
        # a turn w of the flange moves what is beyond it by w x beyond
        shift = by[:, :3] - np.cross(beyond[:, :, None], by[:, 3:], axis=1)
        return np.concatenate([shift, by[:, 3:]], axis=1)

    by_unknowns = moved(at.by_unknowns)
    by_unknowns[:, :3, ball] = at.R
    by_tool = np.concatenate([-at.R @ cross_matrices(arm), at.R], axis=1)
    ones = np.tile(np.eye(3), (len(reach), 1, 1))
    by_places = np.block([[-ones, cross_matrices(reach)], [np.zeros_like(ones), -ones]])
    n = rows.axes
    parts = (by_unknowns, by_tool, by_places[:, :, :n], moved(at.by_joints))
    return (errors[:, :n], *(part[:, :n] for part in parts))


def cross_matrices(v: np.ndarray) -> np.ndarray:
    """Return the matrices of v x, shape (N, 3, 3), of vectors, shape (N, 3)."""
    return np.cross(v[:, :, None], np.eye(3)[None], axis=1)

"""Samples of an arm as two ways to one place, and their errors by all unknowns.

With F(q) the flange by the calibrated chain, U a tool or camera on it, and V a place in the base,

    F(q_i) U L_i = V_k(i) R_i

where L_i or R_i is what a camera or an instrument measured, and the other the identity. A tool's
tip in a socket has neither: U is the tip's place on the flange, and V the socket's centre. A camera
on the arm measures L_i, the board's pose; one beside the arm measures R_i. The errors are

    t_i = p(F U L) - p(V R)      r_i = log(rot(F U L) rot(V R)^T)

in the base's axes, and derivatives are by small turns about the axes of flange (U) and base (V).
Places that a camera measured are as large as its board was said to be: their size is an unknown,
the logarithm of a factor on them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..bayes.model import NU
from ..data import HandEye
from ..robot import matrix_rpy, rotation_vectors
from .prior import ArmPrior

SIZE = 3e-3
"""Relative standard deviation of the size of a printed board that a caliper measured."""
FAR, ANY_TURN = 1.0, 3.0
"""Standard deviations of what is not known at all [m], [rad]."""


@dataclass(frozen=True)
class Rows:
    """Samples: joint positions, the place each belongs to, and poses that were measured."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    moments: np.ndarray
    """Moments that hold the joints, shape (N, 3 m) [N m]."""
    places: np.ndarray
    """Index of each sample's place V, shape (N,)."""
    names: tuple[str, ...]
    """Of the places."""
    left: np.ndarray
    """L, shape (N, 4, 4)."""
    right: np.ndarray
    """R, shape (N, 4, 4)."""
    turns: bool = False
    """True where orientations were measured, too."""
    wheres: tuple[str, ...] = ()
    """File and line of each sample, for messages."""

    @property
    def axes(self) -> int:
        """Number of errors of a sample, 3 or 6."""
        return 6 if self.turns else 3

    def resized(self, size: float) -> "Rows":
        """Return the same with measured places exp(size) times as far away."""
        first, second = self.left.copy(), self.right.copy()
        for poses in (first, second):
            poses[:, :3, 3] *= np.exp(size)
        return replace(self, left=first, right=second)


@dataclass(frozen=True)
class NoiseBelief:
    """Prior of the noise."""

    place: float
    """s_t, of a place [m]."""
    turn: float = 1e-3
    """s_r, of a turn [rad]."""
    joint: float = 0.0
    """s_q, of the joints' angles [rad]; as the calibration found it."""
    nu: float = NU
    """Degrees of freedom of the errors' tails, by the calibration."""
    spread: float = 0.3
    """Standard deviation of the logarithms of s_t and s_r."""


@dataclass(frozen=True)
class Task:
    """A partial fit: an arm's prior, samples, and what is free."""

    prior: ArmPrior
    rows: Rows
    noise: NoiseBelief
    free: dict[int, float] = field(default_factory=dict[int, float])
    """Standard deviations by which the prior of some unknowns is widened."""
    distances: Sequence[tuple[int, int, float]] = ()
    """Known distances: two places, and how far they are apart [m]."""
    start: HandEye | None = None
    """Where U's rotation and the one place begin; None for places at the median of the tips."""
    warnings: tuple[str, ...] = ()
    """Remarks on the samples."""

    @cached_property
    def known(self) -> list[int]:
        """Places that stand where the calibration saw them."""
        return [k for k, name in enumerate(self.rows.names) if name in self.prior.sockets]

    @cached_property
    def tool_turn(self) -> slice:
        """Indices of the unknowns that turn U."""
        n = len(self.prior.mean)
        return slice(n, n + (3 if self.rows.turns else 0))

    @cached_property
    def scale(self) -> slice:
        """Index of the size of measured places; none where no camera measured them."""
        n = self.tool_turn.stop
        return slice(n, n + self.rows.turns)

    @cached_property
    def size(self) -> int:
        """Number of all unknowns."""
        new = len(self.rows.names) - len(self.known)
        return self.scale.stop + self.rows.axes * new

    @cached_property
    def places(self) -> list[np.ndarray]:
        """Indices of each place's unknowns: those of a known socket, or new ones at the end."""
        sockets, axes, end = self.prior.sockets, self.rows.axes, self.scale.stop
        indices: list[np.ndarray] = []
        for name in self.rows.names:
            new = name not in sockets
            indices.append(end + np.arange(axes) if new else sockets[name] + np.arange(3))
            end += axes * new
        return indices

    @property
    def with_exact_arm(self) -> "Task":
        """The same with an arm of which all is known but what is free."""
        return replace(self, prior=replace(self.prior, covariance=0 * self.prior.covariance))

    @cached_property
    def covariance(self) -> np.ndarray:
        """S, shape (size, size)."""
        n, axes, pose = len(self.prior.mean), self.rows.axes, [FAR] * 3 + [ANY_TURN] * 3
        new = len(self.rows.names) - len(self.known)
        size = [SIZE] if self.rows.turns else []
        S = np.diag([0.0] * n + pose[3:axes] + size + pose[:axes] * new) ** 2
        S[:n, :n] = self.prior.covariance
        for i, width in self.free.items():
            S[i, i] += width**2
        return S


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


def flanges(prior: ArmPrior, x: np.ndarray, q: np.ndarray, moments: np.ndarray) -> Flanges:
    """Return the flange's poses by an arm's unknowns: those of a ball in the flange's origin."""
    model, y = prior.model, x[: prior.model.size].copy()
    y[prior.ball] = -model.ball.nominal[prior.ball]
    p, *of_p = model.linearise(y, q, moments)
    R, *of_turns = model.linearise(y, q, moments, of_turns=True)
    by_unknowns, by_joints = [
        np.concatenate(blocks, axis=1) for blocks in zip(of_p, of_turns, strict=True)
    ]
    by_unknowns[:, :, [i for i, p in enumerate(model.parameters) if p.of_ball]] = 0.0
    of_ball = matrix_rpy(model.ball.origins(model.values(y))[-1, 3:])
    return Flanges(R @ of_ball.T, p, by_unknowns, by_joints)


def linearise(
    rows: Rows, poses: Flanges, ball: np.ndarray, tool: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Return errors [m], [rad], and their derivatives: unknowns, U's turn and size, places, joints.

    Each of shape (N, 3 or 6, ...): an orientation that was not measured has no error.
    """
    L, R, V = rows.left, rows.right, places[rows.places]
    arm = np.einsum("ij,nj->ni", tool[:3, :3], L[:, :3, 3])
    lever = np.einsum("nij,nj->ni", poses.R, arm + tool[:3, 3])
    reach = np.einsum("nij,nj->ni", V[:, :3, :3], R[:, :3, 3])
    turned = poses.R @ tool[:3, :3] @ L[:, :3, :3]
    turn_errors = turned @ (V[:, :3, :3] @ R[:, :3, :3]).transpose(0, 2, 1)
    errors = np.concatenate(
        [poses.p + lever - V[:, :3, 3] - reach, rotation_vectors(turn_errors)], axis=1
    )
    by_unknowns, by_joints = poses.by_unknowns.copy(), poses.by_joints.copy()
    for slopes in (
        by_unknowns,
        by_joints,
    ):  # a turn w of the flange moves the lever's end by w x lever
        slopes[:, :3] -= np.cross(lever[:, :, None], slopes[:, 3:], axis=1)
    by_unknowns[:, :3, ball] = poses.R
    by_turn = np.concatenate([-poses.R @ _cross_matrices(arm), poses.R], axis=1)
    by_size = np.zeros((len(reach), 6, 1))
    by_size[:, :3, 0] = np.einsum("nij,nj->ni", poses.R, arm) - reach
    by_tool = np.concatenate([by_turn, by_size], axis=2)
    ones = np.tile(np.eye(3), (len(reach), 1, 1))
    by_places = np.block([[-ones, _cross_matrices(reach)], [0 * ones, -ones]])[:, :, : rows.axes]
    parts = (errors, by_unknowns, by_tool, by_places, by_joints)
    return tuple(part[:, : rows.axes] for part in parts)


def _cross_matrices(v: np.ndarray) -> np.ndarray:
    """Return the matrices of v x, shape (N, 3, 3), of vectors, shape (N, 3)."""
    return np.cross(v[:, :, None], np.eye(3)[None], axis=1)

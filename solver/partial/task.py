"""Samples of an arm as two ways to one place, and what is unknown of both.

With F(q) the flange by the calibrated chain, U a tool or camera on it, and V a place in the base,

    F(q_i) U L_i = V_k(i) R_i

where L_i or R_i is what a camera or an instrument measured, and the other the identity. A tool's
tip in a socket has neither: U is the tip's place on the flange, and V the socket's centre. A camera
on the arm measures L_i, the board's pose; one beside the arm measures R_i. Places that a camera
measured are as large as its board was said to be: their size is an unknown, the logarithm of a
factor on them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

import numpy as np

from ..identification.data import UNIFORM, HandEye, Measurement, Samples, steps_of
from ..identification.model import NU, Gaussian
from .prior import ArmPrior

SIZE = 3e-3
"""Relative standard deviation of the size of a printed board that a caliper measured."""
FAR, ANY_TURN = 1.0, 3.0
"""Standard deviations of what is not known at all [m], [rad]."""


@dataclass(frozen=True, kw_only=True)
class Rows(Samples):
    """Samples, the place each belongs to, and poses that were measured."""

    places: np.ndarray
    """Index of each sample's place V, shape (N,)."""
    names: tuple[str, ...]
    """Of the places."""
    wheres: np.ndarray
    """File and line of each sample, for messages, shape (N,)."""
    warnings: tuple[str, ...]
    """Remarks on the samples."""
    left: np.ndarray
    """L, shape (N, 4, 4)."""
    right: np.ndarray
    """R, likewise."""
    turns: bool = False
    """True where orientations were measured, too."""
    framed: bool = False
    """True where each place is the frame of an instrument, in which R says where the tip was."""

    @staticmethod
    def of(
        prior: ArmPrior,
        data: Sequence[Measurement],
        places: np.ndarray,
        names: tuple[str, ...],
    ) -> "Rows":
        """Return the samples of placements, at the arm's load."""
        samples = prior.load.samples(prior.robot, *data)
        warnings = chain.from_iterable(m.warnings for m in data)
        identity = np.tile(np.eye(4), (len(places), 1, 1))
        return Rows(
            **vars(samples),
            places=places,
            names=names,
            wheres=np.concatenate([m.wheres for m in data]),
            warnings=tuple(warnings),
            left=identity,
            right=identity,
        )

    @property
    def axes(self) -> int:
        """Number of errors of a sample, 3 or 6."""
        return 6 if self.turns else 3

    @property
    def place_axes(self) -> int:
        """Number of unknowns of a place: 6 of one that turns, or 3."""
        return 6 if self.turns or self.framed else 3

    @cached_property
    def rounding(self) -> np.ndarray:
        """Standard deviations of joints that read in steps, shape (m,) [rad]; 0 for all others."""
        return UNIFORM * steps_of(self.q)

    def resized(self, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Return L and R with measured places exp(size) times as far away."""
        factors = np.ones((4, 4))
        factors[:3, 3] = np.exp(size)
        return self.left * factors, self.right * factors


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
    free: Mapping[int, float] = field(default_factory=dict[int, float])
    """Standard deviations by which the prior of some unknowns is widened."""
    distances: Sequence[tuple[int, int, float]] = ()
    """Known distances: two places, and how far they are apart [m]."""
    exact_size: bool = False
    """True where an instrument measured places, whose size is right."""
    start: HandEye | None = None
    """Start of U's rotation and of the one place; None for places at the median of the tips."""

    @cached_property
    def known(self) -> list[int]:
        """Places that stand where the calibration saw them."""
        names = enumerate(self.rows.names)
        return [k for k, name in names if name in self.prior.sockets]

    @cached_property
    def tool_turn(self) -> slice:
        """Indices of the unknowns that turn U."""
        n = len(self.prior.mean)
        return slice(n, n + 3 * self.rows.turns)

    @cached_property
    def scale(self) -> slice:
        """Index of the size of measured places; none where no camera measured them."""
        n = self.tool_turn.stop
        return slice(n, n + self.rows.turns)

    @cached_property
    def size(self) -> int:
        """Number of all unknowns."""
        new = len(self.rows.names) - len(self.known)
        return self.scale.stop + self.rows.place_axes * new

    @cached_property
    def places(self) -> np.ndarray:
        """Indices of each place's unknowns, those of new places at the end, (K, place_axes)."""
        axes = self.rows.place_axes
        end = self.scale.stop
        begins: list[int] = []
        for name in self.rows.names:
            if name in self.prior.sockets:
                begins.append(self.prior.sockets[name])
            else:
                begins.append(end)
                end += axes
        return np.add.outer(begins, np.arange(axes))

    @property
    def with_exact_arm(self) -> "Task":
        """The same with an arm of which all is known but what is free."""
        exact = replace(self.prior, covariance=np.zeros_like(self.prior.covariance))
        return replace(self, prior=exact)

    def tolerating(self, factor: float) -> "Task":
        """Return the same of an arm whose parts are less exact by a factor."""
        return replace(self, prior=self.prior.tolerating(factor))

    def freeing(self, widths: Mapping[int, float]) -> "Task":
        """Return the same with more that is free."""
        return replace(self, free={**self.free, **widths})

    def mean(self, x: np.ndarray) -> np.ndarray:
        """Return mu, of which turns, and places that nothing is known of, are where x has them."""
        mean = x.copy()
        mean[: len(self.prior.mean)] = self.prior.mean
        mean[self.scale] = 0.0
        return mean

    @cached_property
    def independent(self) -> Gaussian:
        """The unknowns less mu, by a root F of S, shape (size, size)."""
        return Gaussian.of(np.zeros(self.size), self.covariance)

    @cached_property
    def covariance(self) -> np.ndarray:
        """S, shape (size, size)."""
        n = len(self.prior.mean)
        deviations = np.full(self.size, FAR)
        deviations[self.tool_turn] = ANY_TURN
        deviations[self.scale] = 0.0 if self.exact_size else SIZE
        deviations[self.places[:, 3:]] = ANY_TURN
        S = np.diag(deviations**2)
        S[:n, :n] = self.prior.covariance
        for i, width in self.free.items():
            S[i, i] += width**2
        return S


@dataclass(frozen=True)
class State:
    """Unknowns of a task, and what the samples weigh by them."""

    x: np.ndarray
    """The unknowns, shape (size,); their turns are 0, since these are in the rotations."""
    tool: np.ndarray
    """Rotation of U, shape (3, 3)."""
    places: np.ndarray
    """Rotations of V, shape (K, 3, 3)."""
    noise: NoiseBelief
    weights: np.ndarray
    """Robust weight of each sample, shape (N,)."""

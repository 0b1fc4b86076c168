"""The unknowns of the extended model, their priors, and what was observed.

The unknowns are the geometry (as change from nominal), the coefficients of the extensions, and the
socket centres. Each group of unknowns has a Gaussian prior of its own width.
"""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .deflection import COMPLIANCE, EXTENSIONS, Deflection, design
from .kinematics import BallModel
from .observations import Observations
from .parameters import Parameter
from .urdf import Chain

__all__ = ["Group", "MapProblem", "Noise", "build_map_problem"]

Vector = NDArray[np.float64]
BALL_WIDTH = 0.1
"""Prior of the ball's place on the flange [m]: hardly any."""
NEGLIGIBLE = 0.05
"""A scale that moves the ball by less than this part of the noise is nothing."""
TRANSMISSION_SCALE = 5e-4
"""Transmission errors much wider than this are implausible [rad]: the prior of their width."""


@dataclass(frozen=True)
class Group:
    """Unknowns that share one prior, of mean 0 and width (standard deviation) s_g."""

    name: str
    unit: str
    members: NDArray[np.int64]
    """Their indices among the unknowns."""
    width: float
    scale: float = np.inf
    """Of a half-normal prior on the width itself."""
    learned: bool = True
    """Whether the evidence sets the width."""
    effective: float = 0.0
    """gamma_g: how many of its unknowns the data decide."""

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, the uncertainty of its own width included.

        With a width learned from gamma unknowns integrated out, the prior is Student's with gamma
        degrees of freedom, whose variance is gamma / (gamma - 2) larger; twice at most here.
        """
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5 if self.learned else self.width

    def updated(self, squares: float, effective: float) -> "Group":
        """Return the group with the width of the next fixed-point step, gamma s^2 = |x_g|^2."""
        gamma = max(effective, 1e-9)
        square = squares / gamma
        if np.isfinite(self.scale):
            h2 = self.scale**2
            square = h2 * (np.sqrt(gamma**2 + 4 * squares / h2) - gamma) / 2
        return replace(self, width=float(np.sqrt(max(square, 1e-24))), effective=effective)


@dataclass(frozen=True)
class Noise:
    """Scales of the noise."""

    space: float
    """s_x [m]."""
    joint: float
    """s_q [rad]; 0 where the data do not support it."""

    def updated(self, step: Vector, effect: float) -> "Noise":
        """Return the noise after a step of its squares, each by a factor of 4 at most.

        Noise in space is kept from zero, since no ball sits without any play.

        Args:
            step: Change of s_x^2 [m^2] and, unless it is zero, of s_q^2 [rad^2].
            effect: What the noise of the joints does to the ball, relative to that in space.
        """
        squares = np.array([self.space, self.joint])[: len(step)] ** 2
        scales = np.sqrt(np.clip(squares + step, squares / 4, 4 * squares)).tolist()
        s_x, s_q = scales if len(scales) == 2 else (scales[0], 0.0)
        reach = effect * self.space / self.joint if self.joint else 0.0
        return Noise(max(s_x, NEGLIGIBLE * s_q * reach, 1e-9), s_q)

    def scales(self, by_joints: Vector) -> Vector:
        """Return C_i for each sample's Jq, shape (N, 3, 3)."""
        spread = by_joints @ by_joints.transpose(0, 2, 1)
        return self.space**2 * np.eye(3) + self.joint**2 * spread


@dataclass(frozen=True)
class MapProblem:
    """The unknowns and their priors, and what was observed; inspectable before it is solved."""

    chain: Chain
    parameters: tuple[Parameter, ...]
    model: BallModel
    data: Observations
    extensions: tuple[str, ...]
    groups: tuple[Group, ...]

    @property
    def geometry(self) -> int:
        """Number of geometric unknowns; those of the extensions follow, then the centres."""
        return len(self.parameters)

    @property
    def size(self) -> int:
        """Number of unknowns before the socket centres."""
        return self.geometry + sum(self.sizes)

    @property
    def sizes(self) -> list[int]:
        """Number of coefficients of each extension."""
        m = len(self.chain.actuated)
        return [m if extension == COMPLIANCE else 2 * m for extension in self.extensions]

    def design(self, q: Vector, torque: Vector) -> Vector:
        """Return how all extensions' coefficients shift the joints, shape (N, m, p)."""
        parts = [design(extension, q, torque) for extension in self.extensions]
        return np.concatenate([np.zeros((*q.shape, 0)), *parts], axis=2)

    def deflection(self, x: Vector) -> Deflection:
        """Return the extensions at some unknowns."""
        ends = self.geometry + np.cumsum(self.sizes)
        values = tuple(x[end - size : end] for end, size in zip(ends, self.sizes, strict=True))
        return Deflection(self.extensions, values)

    def linearise(self, x: Vector, q: Vector, torque: Vector) -> tuple[Vector, Vector, Vector]:
        """Return ball centres (N, 3), and derivatives by the unknowns and by the joints."""
        shifts = self.design(q, torque)
        true = q + shifts @ x[self.geometry :]
        linear = self.model.linearise(self.model.nominal + x[: self.geometry], true)
        by_unknowns = np.concatenate([linear.by_parameters, linear.by_joints @ shifts], axis=2)
        return linear.points, by_unknowns, linear.by_joints


def build_map_problem(
    chain: Chain,
    parameters: Sequence[Parameter],
    data: Observations,
    extensions: Sequence[str] = (),
) -> MapProblem:
    """Return the problem with its groups at their starting widths.

    Args:
        chain: The robot.
        parameters: What of its geometry is free.
        data: What was observed.
        extensions: Among :data:`EXTENSIONS`.
    """
    kinds = [
        ("ball" if p.of_ball else "translation" if p.unit == "m" else "rotation")
        for p in parameters
    ]
    units = {"translation": ("m", 1e-3), "rotation": ("rad", 5e-3), "ball": ("m, rad", BALL_WIDTH)}
    groups = [
        Group(
            name,
            unit,
            np.flatnonzero([kind == name for kind in kinds]),
            width,
            learned=name != "ball",
        )
        for name, (unit, width) in units.items()
    ]
    begin, m = len(parameters), len(chain.actuated)
    for extension in (e for e in EXTENSIONS if e in extensions):
        size = m if extension == COMPLIANCE else 2 * m
        members = np.arange(begin, begin + size)
        if extension == COMPLIANCE:
            torque = float(np.sqrt(np.mean(data.torques**2)))
            groups.append(Group(extension, "rad/(N m)", members, 5e-4 / max(torque, 1e-6)))
        else:
            groups.append(Group(extension, "rad", members, 5e-4, scale=TRANSMISSION_SCALE))
        begin += size
    model = BallModel(chain, [p.index for p in parameters])
    ordered = tuple(e for e in EXTENSIONS if e in extensions)
    present = tuple(group for group in groups if len(group.members))
    return MapProblem(chain, tuple(parameters), model, data, ordered, present)

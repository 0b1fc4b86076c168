"""The unknowns of the extended model, their priors, and what was observed.

The unknowns are the geometry (as change from nominal), the coefficients of the extensions, and the
socket centres. Each group of unknowns has a Gaussian prior of its own width.
"""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..data.observations import Observations
from ..robot.kinematics import BallModel, workspace
from ..robot.parameters import Parameter
from ..robot.urdf import Robot
from .deflection import COMPLIANCE, EXTENSIONS, Deflection, design
from .priors import Group

__all__ = ["MapProblem", "build_map_problem"]

Vector = NDArray[np.float64]
BALL_WIDTH = 0.1
"""Prior of the ball's place on the flange [m]: hardly any."""
COMMON_SCALE = 2e-3
"""Prior of the scale of all lengths together: wide beside the 0.06 % that a caliper tells of a
50 mm base, so that measured distances rule, and narrow enough to hold where an arm is noisy."""
SCALE_SAMPLES = 200
TRANSMISSION_SCALE = 5e-4
"""Transmission errors much wider than this are implausible [rad]: the prior of their width."""


@dataclass(frozen=True)
class MapProblem:
    """The unknowns and their priors, and what was observed; inspectable before it is solved."""

    robot: Robot
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
        m = len(self.robot.actuated)
        return [m if extension == COMPLIANCE else 2 * m for extension in self.extensions]

    def by_scale(self) -> Vector:
        """Return the derivative of the logarithm of the model's scale by the unknowns.

        The scale is the size of the cloud of ball positions in the workspace. Unlike the lengths
        in the model, it does not depend on which of many equivalent descriptions they are.
        """
        q = workspace(self.robot, SCALE_SAMPLES)
        points, slopes, _ = self.linearise(np.zeros(self.size), q, np.zeros_like(q))
        cloud = points - points.mean(axis=0)
        return np.einsum("ni,nij->j", cloud, slopes) / np.sum(cloud**2)

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
    robot: Robot,
    parameters: Sequence[Parameter],
    data: Observations,
    extensions: Sequence[str] = (),
) -> MapProblem:
    """Return the problem with its groups at their starting widths.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        data: What was observed.
        extensions: Among :data:`EXTENSIONS`.
    """
    kinds = [
        ("ball" if p.of_ball else "translation" if p.unit == "m" else "rotation")
        for p in parameters
    ]
    units = {"translation": ("m", 1e-3), "rotation": ("rad", 5e-3), "ball": ("m, rad", BALL_WIDTH)}
    model = BallModel(robot, [p.index for p in parameters])
    lengths = np.flatnonzero([kind == "translation" for kind in kinds])
    groups = [
        Group(
            name,
            unit,
            np.flatnonzero([kind == name for kind in kinds]),
            width,
            learned=name != "ball",
            together=COMMON_SCALE * model.nominal[lengths] if name == "translation" else None,
        )
        for name, (unit, width) in units.items()
    ]
    begin, m = len(parameters), len(robot.actuated)
    for extension in (e for e in EXTENSIONS if e in extensions):
        size = m if extension == COMPLIANCE else 2 * m
        members = np.arange(begin, begin + size)
        if extension == COMPLIANCE:
            torque = float(np.sqrt(np.mean(data.torques**2)))
            groups.append(Group(extension, "rad/(N m)", members, 5e-4 / max(torque, 1e-6)))
        else:
            groups.append(Group(extension, "rad", members, 5e-4, scale=TRANSMISSION_SCALE))
        begin += size
    ordered = tuple(e for e in EXTENSIONS if e in extensions)
    present = tuple(group for group in groups if len(group.members))
    return MapProblem(robot, tuple(parameters), model, data, ordered, present)

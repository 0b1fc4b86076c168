"""A physical effect on the pose, as a value: what it is called, shifts, and is believed to be."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np

Array: TypeAlias = "np.ndarray"
"""The command line reads the names of effects without numpy."""
OWN, ACROSS_1, ACROSS_2 = 0, 1, 2
"""Axes of a joint: its own, and the two of :attr:`mukca.solver.robot.Joint.tilt_axes`."""


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect whose coefficients each turn one axis of one joint, in proportion to themselves."""

    name: str
    """Key of its coefficients in ``calibration.json``."""
    extension: str
    """Name under which it is tried, kept and left out (``--without``), alone or with others; empty
    for an effect that only an option asks for."""
    unit: str
    """Of its coefficients."""
    axes: Mapping[str, int]
    """Suffix of a coefficient, named JOINT.SUFFIX, to the axis of the joint that it turns."""
    derivatives: Callable[[Array, Array], Array]
    """Turn of the axes per unit of each coefficient, suffix after suffix, shape (N, p), from joint
    positions, shape (N, m) [rad], and the moments that hold the joints, shape (N, 3 m) [N m]."""
    typical_shift: float
    """Typical turn of a joint, its root mean square over the samples [rad]: the prior's width."""
    learned: bool = True
    """True if the evidence sets the prior's width, around the typical one."""
    non_negative: bool = False
    """True if no coefficient can be below zero, since nothing gives way against its load."""
    shared_by_type: bool = False
    """True if arms of one type have much the same coefficients."""
    joint_noise: Callable[[Array], Array] | None = None
    """Noise of each joint's angle as a share of its usual one, shape (N, m), from the torques; its
    coefficients are then believed to be what the joints' noise shows. None for an even noise."""
    requires: str = ""
    """Another effect without which it is not tried."""
    shift: Callable[[Array, Array], Array] | None = None
    """Turn of the joints about their own axes, shape (N, m) [rad], from their positions and all
    coefficients, where that is far less work than by the derivatives."""
    geometry_widths: Mapping[str, float] = field(default_factory=dict[str, float])
    """Typical widths of groups of the geometry beside this effect, by name [m, rad]."""

    def coefficient_names(self, joints: Sequence[str]) -> list[str]:
        """Names of the coefficients, in the order of :attr:`derivatives`."""
        return [f"{joint}.{suffix}" for suffix, joint in product(self.axes, joints)]

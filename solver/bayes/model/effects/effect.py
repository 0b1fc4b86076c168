"""A physical effect on the pose, as a value: what it is called, shifts, and is believed to be."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .. import Expected, PriorGroup

OWN, ACROSS_1, ACROSS_2 = 0, 1, 2
"""Axes of a joint: its own, and the two across, b and c of :func:`mukca.solver.robot.across`."""
SHARED_DEVIATION = 0.3
"""Typical difference between two arms of a type, as a share of an effect's size."""


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
    derivatives: Callable[[np.ndarray, np.ndarray], np.ndarray]
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
    joint_noise: Callable[[np.ndarray], np.ndarray] | None = None
    """Noise of each joint's angle as a share of its usual one, shape (N, m), from the torques; its
    coefficients are then believed to be what the joints' noise shows. None for an even noise."""
    requires: str = ""
    """Another effect without which it is not tried."""
    geometry_widths: Mapping[str, float] = field(default_factory=dict[str, float])
    """Typical widths of groups of the geometry beside this effect, by name [m, rad]."""

    def coefficient_names(self, joints: Sequence[str]) -> list[str]:
        """Names of the coefficients, in the order of :attr:`derivatives`."""
        return [f"{joint}.{suffix}" for suffix in self.axes for joint in joints]

    def prior(
        self, members: np.ndarray, q: np.ndarray, moments: np.ndarray, of_type: Expected | None
    ) -> PriorGroup:
        """Return the prior of the coefficients, at the width from which the estimation starts.

        Args:
            members: Their indices among the unknowns.
            q: Joint positions of the samples, shape (N, m) [rad].
            moments: As for :attr:`derivatives`: they tell the size of a plausible coefficient.
            of_type: The coefficients of other arms of the type, where they are known.
        """
        shifts = self.derivatives(q, moments)
        width = self.typical_shift / max(float(np.sqrt(np.mean(shifts**2))), 1e-6)
        if of_type is not None:
            width = SHARED_DEVIATION * float(np.sqrt(np.mean(of_type[0] ** 2)))
        group = PriorGroup(
            self.name,
            self.unit,
            members,
            width,
            typical=width if self.learned else 0.0,
            learned=self.learned,
            expected=of_type,
            optional=True,
            non_negative=self.non_negative,
            follows_noise=self.joint_noise is not None,
        )
        return group.following(self.typical_shift) if group.follows_noise else group

"""A physical effect on the pose, as a value: what it is called, shifts, and is believed to be."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Literal, TypeAlias

from ..data import Samples

if TYPE_CHECKING:
    import numpy as np

Array: TypeAlias = "np.ndarray"
"""The command line reads the names of effects without numpy."""
OWN, ACROSS_1, ACROSS_2 = 0, 1, 2
"""Axes of a joint: its own, and the two of :attr:`.Joint.tilt_axes`."""
Joints: TypeAlias = Literal["all", "first"]


@dataclass(frozen=True)
class Display:
    """The looks of an effect's coefficients where people read them."""

    unit: str
    factor: float = 1.0
    """Of the SI unit."""
    usual_turn: float = 0.0
    """Turn of a joint by a coefficient of 1 where it stands and bears what joints usually do [rad];
    0 draws no limit of what matters at the ball."""
    usual_words: str = ""
    """Such a place or load, as the report's caption has it."""
    heading: str = "corrections of joints"
    """Title of the plot of all coefficients that have the same."""
    by_joint: bool = False
    """True if that plot names each coefficient by its joint alone."""

    @property
    def per_mm(self) -> float:
        """Change that moves a ball 1 m away by 1 mm, in the unit shown; 0 where it is not known."""
        return 1e-3 * self.factor / self.usual_turn if self.usual_turn else 0.0


ANGLES = Display("mrad", 1e3, usual_turn=1.0)


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect whose coefficients each turn one axis of one joint, in proportion to themselves."""

    name: str
    """Key of its coefficients in ``calibration.json``."""
    extension: str
    """Name under which it is tried, kept and left out (``--without``), alone or with others; empty
    for an effect that only an option asks for, or what was seen of the recordings."""
    unit: str
    """Of its coefficients."""
    axes: Mapping[str, int]
    """Suffix of a coefficient, named JOINT.SUFFIX, to the axis of the joint that it turns."""
    derivatives: Callable[[Samples], Array]
    """Turn of the axes of all joints per unit of a coefficient, suffix after suffix, shape
    (N, m suffixes), of samples."""
    typical_shift: float
    """Typical turn of a joint, its root mean square over the samples [rad]: the prior's width."""
    joints: Joints = "all"
    """Joints that have it: all that move, or the first of the chain alone."""
    shown: Display | None = None
    """Its looks in reports; None for milliradians if it is an angle, else for its own unit."""
    zeros: bool = False
    """True if joint origins can hold it, and only arms whose zeros are set by eye (``--zeros``)
    have it."""
    of_encoder: bool = False
    """True if an encoder reads wrongly by it, which says nothing about lengths."""
    learned: bool = True
    """True if the evidence sets the prior's width, around the typical one."""
    rare: bool = False
    """True if joints have none of it but those of which the recordings show it."""
    non_negative: bool = False
    """True if no coefficient can be below zero, since nothing gives way against its load."""
    joint_noise: Callable[[Array], Array] | None = None
    """Noise of each joint's angle as a share of its usual one, shape (N, m), from the torques; its
    coefficients are then believed to be what the joints' noise shows. None for an even noise."""
    elastic: bool = False
    """True if joints give way under load; an arm that does so about one axis does about others."""
    stands_for_curves: bool = False
    """True if it takes the place of error curves where the data tell of no curves."""
    random: "Callable[[int, np.random.Generator], Array] | None" = None
    """Coefficients of size 1 drawn for so many joints; None for numbers that are independent."""
    requires: str = ""
    """Another effect without which it is not tried."""
    shift: Callable[[Array, Array], Array] | None = None
    """Turn of the joints about their own axes, shape (N, m) [rad], from their positions and all
    coefficients, where that is far less work than by the derivatives."""
    geometry_widths: Mapping[str, float] = field(default_factory=dict[str, float])
    """Typical widths of groups of the geometry beside this effect, by name [m, rad]."""

    @property
    def display(self) -> Display:
        """Its looks in reports."""
        return self.shown or (ANGLES if self.unit == "rad" else Display(self.unit))

    @property
    def across(self) -> bool:
        """True if joints turn about axes across their own."""
        return any(axis != OWN for axis in self.axes.values())

    @property
    def columns(self) -> slice:
        """Columns of the joints that have it."""
        return slice(1) if self.joints == "first" else slice(None)

    def coefficient_names(self, joints: Sequence[str]) -> list[str]:
        """Names of the coefficients, in the order of :meth:`turns`."""
        pairs = product(self.axes, joints[self.columns])
        return [f"{joint}.{suffix}" for suffix, joint in pairs]

    def turns(self, samples: Samples) -> Array:
        """Return the turn of its joints' axes per unit of each coefficient, shape (N, p) [rad]."""
        turns = self.derivatives(samples)
        if self.joints == "all":
            return turns
        N, m = samples.q.shape
        by_joint = turns.reshape(N, len(self.axes), m)
        return by_joint[:, :, self.columns].reshape(N, -1)

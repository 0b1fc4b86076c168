"""The priors: what is believed of the unknowns before the data, group by group.

The unknowns x_g of a group g, for instance all angles of the joint origins, have a Gaussian prior
with mean 0 and one common standard deviation, the width s_g. Where other arms of the type tell the
elasticity, its mean is theirs instead, and each coefficient's own uncertainty adds to its width.
How wide it is follows from the data, by the evidence (see docs/model.md). The lengths may also all
grow or shrink together, by the same share, which is the scale of the whole robot; that costs much
less than so many separate changes.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from ...data import Observations
from .deflection import COMPLIANCE, ELASTICITY, PLAY, ZERO
from .extended_model import Expected, ExtendedModel

BALL_WIDTH = 0.1
"""Width of the prior of the ball's place on the flange [m]: so wide that the data decide alone."""
TRANSLATION_WIDTH, ROTATION_WIDTH = 1e-3, 5e-3
"""Widths of lengths [m] and angles [rad] at the start of the estimation."""
COMMON_SCALE = 2e-3
"""Standard deviation of the whole robot's scale, 0.2 %. A caliper on a base of 50 mm gives the
scale to 0.06 %, so measured distances decide; where an arm is noisy, the URDF's scale holds."""
DEFLECTION = 5e-4
"""Typical width of elasticity, as an angle by which a joint is off under its usual load [rad]."""
TRANSMISSION_WIDTH = 1e-4
"""Typical width of the coefficients of a harmonic [rad]. Makers of harmonic drives state one arc
minute from peak to peak: an amplitude of 0.15 mrad, shared by a sine and a cosine."""
JOINT_OFFSET_WIDTH = float(np.deg2rad(3))
"""Width of the joints' zeros, where they may be off: as they are set by eye [rad]."""
PRINTED = {"translation": 2e-4, "rotation": 7e-4}
"""Typical widths of lengths [m] and angles [rad] where the zeros are free, too: what printed parts
are off by. The zeros are then the larger part of what is wrong with the angles."""
HALF_BACKLASH = float(np.deg2rad(0.3))
"""Of a servo, as it is believed to be until the noise of its joints shows it [rad]."""
TYPICAL_SPREAD = 1.0
"""Standard deviation of the logarithm of a width whose typical value is known: a factor e."""
MIN_WIDTH, MAX_WIDTH = 0.3, 10.0
"""A width's step is the one of (A4) times a factor between these two, by how well earlier steps
went."""
SHARED_DEVIATION = 0.3
"""By what share of itself the elasticity of one arm differs from that of its type; and half the
play of a joint from that of the others, and that of all from what their noise shows."""
FALLING = 0.05
"""Relative change in a step from which on a width falls, and not just settles."""
SMALLEST_WIDTH = 1e-9
"""A width is never less: rounding would leave nothing of the scale that lengths share."""
EVERY = slice(None)


@dataclass(frozen=True)
class PriorGroup:
    """Unknowns that share one prior, of mean 0 and width (standard deviation) s_g."""

    name: str
    unit: str
    """Of its unknowns, and so of the width."""
    members: np.ndarray
    """Their indices among the unknowns."""
    width: float
    """s_g; 0 holds the members at zero."""
    typical: float = 0.0
    """What the width is believed to be before the data, within a factor e; 0 for no belief."""
    learned: bool = True
    """Whether the evidence sets the width."""
    effective: float = 0.0
    """gamma_g: how many of its unknowns the data decide, from 0 to their number."""
    trail: tuple[float, float] | None = None
    """Logarithm of the width before the last step, and by how much (A4) wanted it changed."""
    common: np.ndarray | None = None
    """t: a change of all members together that the prior allows in addition, shape (members,).
    For lengths it is how they change when the whole robot grows by 0.2 %. None: no such change."""
    expected: Expected | None = None
    """What other arms of the type have, or what the noise shows of play, and how well that is
    known; None for zero, exactly."""

    def covariance(self, width: float) -> np.ndarray:
        """Return the members' prior covariance D + t t^T, for s_g a given width.

        D is s_g^2 I, and with what other arms tell, the squares of its deviations added.
        """
        D = np.diag(self._variances(width))
        return D if self.common is None else D + np.outer(self.common, self.common)

    def precision(self, width: float, free: np.ndarray | slice = EVERY) -> np.ndarray:
        """Return the prior precision (inverse covariance) of some of the members.

        The members that are left out are held at zero. By Sherman and Morrison's formula,
        (D + t t^T)^-1 = D^-1 - D^-1 t t^T D^-1 / (1 + t^T D^-1 t).

        Args:
            width: s, in the unit of the group.
            free: Which members count.
        """
        inverse = 1 / self._variances(width)[free]
        if self.common is None:
            return np.diag(inverse)
        t = self.common[free]
        scaled = inverse * t
        return np.diag(inverse) - np.outer(scaled, scaled) / (1 + t @ scaled)

    @property
    def mean(self) -> np.ndarray:
        """What is believed of the members, shape (members,)."""
        return np.zeros(len(self.members)) if self.expected is None else self.expected[0]

    def _variances(self, width: float) -> np.ndarray:
        own = 0.0 if self.expected is None else self.expected[1] ** 2
        return np.full(len(self.members), width**2) + own

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, larger than its width where that is uncertain itself.

        A width estimated from gamma unknowns is itself uncertain. Counting that makes the prior a
        Student's distribution with gamma degrees of freedom, whose variance is larger by the
        factor gamma / (gamma - 2); here by 2 at most.
        """
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5 if self.learned else self.width

    def updated(self, x: np.ndarray, covariance: np.ndarray, free: np.ndarray) -> "PriorGroup":
        """Return the group with a width closer to what the evidence prefers (MacKay 1992).

            gamma_g = tr(s_g^2 P_g) - tr(P_g Sigma_g P_g) s_g^2    s_g^2 = |x_g|^2 / gamma_g    (A4)

        The new width is the root mean square of the unknowns, over those that the data decide. An
        unknown whose posterior is as wide as its prior was not decided, and counts as 0 in gamma.
        A belief about the width itself, see :attr:`typical`, adds its slope.

        Args:
            x: How far those members that are free are from their mean.
            covariance: Sigma_g, their posterior covariance.
            free: Which members they are.
        """
        P = self.width**2 * self.precision(self.width, free)
        effective = float(np.trace(P) - np.trace(P @ covariance @ P) / self.width**2)
        squares, gamma = float(np.sum((P @ x) ** 2)), max(effective, 1e-9)
        square = squares / gamma
        if self.typical:
            pull = np.log(self.width / self.typical) / TYPICAL_SPREAD**2
            ratio = squares / self.width**2
            step = (ratio - gamma - pull) / (2 * ratio + 1 / TYPICAL_SPREAD**2)
            square = self.width**2 * np.exp(2 * np.clip(step, -1, 1))
        wanted = 0.5 * np.log(max(square, SMALLEST_WIDTH**2))
        now = float(np.log(self.width))
        width = max(float(np.exp(now + self._step(now, wanted - now))), SMALLEST_WIDTH)
        return replace(self, width=width, effective=effective, trail=(now, wanted - now))

    def _step(self, now: float, change: float) -> float:
        """Return by how much to change the logarithm of the width.

        (A4) alone may take hundreds of steps, each a little shorter than the one before, where a
        width vanishes. The secant through this step and the last says where they lead to: nowhere
        if the width falls ever faster, so that it is halved at once.
        """
        if self.trail is None or now == self.trail[0] or not change:
            return change
        slope = (change - self.trail[1]) / (now - self.trail[0])
        if slope < 0:
            return float(np.clip(-1 / slope, MIN_WIDTH, MAX_WIDTH)) * change
        return min(change, -log(2)) if max(change, self.trail[1]) < -FALLING else change


def prior_groups(model: ExtendedModel, data: Observations) -> tuple[PriorGroup, ...]:
    """Return the groups of a model's unknowns, at the widths from which the estimation starts.

    Args:
        model: The model.
        data: What was measured: the torques tell the size of a plausible compliance.
    """
    kinds = [
        "ball" if p.of_ball else "translation" if p.unit == "m" else "rotation"
        for p in model.parameters
    ]
    members = {kind: np.flatnonzero([k == kind for k in kinds]) for kind in kinds}
    no_members = np.zeros(0, dtype=np.int64)
    lengths = members.get("translation", no_members)
    geometry = [
        PriorGroup(
            "translation",
            "m",
            lengths,
            TRANSLATION_WIDTH,
            common=COMMON_SCALE * model.ball.nominal[lengths],
        ),
        PriorGroup("rotation", "rad", members.get("rotation", no_members), ROTATION_WIDTH),
        PriorGroup("ball", "m, rad", members.get("ball", no_members), BALL_WIDTH, learned=False),
    ]
    groups = [group for group in geometry if len(group.members)]
    begin = model.geometry
    for extension, size in zip(model.extensions, model.sizes, strict=True):
        members_here = np.arange(begin, begin + size)
        if extension == ZERO:
            groups = [_printed(group) for group in groups]
            groups.append(PriorGroup(ZERO, "rad", members_here, JOINT_OFFSET_WIDTH, learned=False))
        elif extension in ELASTICITY:
            m = data.positions.shape[1]
            own = data.torques[:, :m] if extension == COMPLIANCE else data.torques[:, m:]
            typical = DEFLECTION / max(float(np.sqrt(np.mean(own**2))), 1e-6)
            expected = model.of_type.get(extension)
            if expected is not None:
                typical = SHARED_DEVIATION * float(np.sqrt(np.mean(expected[0] ** 2)))
            groups.append(
                PriorGroup(
                    extension,
                    "rad/(N m)",
                    members_here,
                    typical,
                    typical=typical,
                    expected=expected,
                )
            )
        elif extension == PLAY:
            groups.append(backlash_group(members_here, HALF_BACKLASH))
        else:
            typical = TRANSMISSION_WIDTH
            groups.append(PriorGroup(extension, "rad", members_here, typical, typical=typical))
        begin += size
    return tuple(groups)


def backlash_group(members: np.ndarray, noise: float) -> PriorGroup:
    """Return the prior of half the play of a robot's joints.

    A joint without load rests anywhere in its play, and its angle is as noisy as half of that. A
    joint that carries its load on one side throughout shows nothing of its own, and what it has
    would pass for its zero: so it is believed to have what the noise shows of the others.

    Args:
        members: The unknowns.
        noise: Standard deviation of the angles of joints without load [rad].
    """
    alike, around = np.ones(len(members)), max(SHARED_DEVIATION * noise, SMALLEST_WIDTH)
    expected = noise * alike, 0 * alike
    common = around * alike
    return PriorGroup(PLAY, "rad", members, around, learned=False, common=common, expected=expected)


def _printed(group: PriorGroup) -> PriorGroup:
    typical = PRINTED.get(group.name)
    return group if typical is None else replace(group, width=typical, typical=typical)

"""What is believed of the unknowns before the data: groups that share a Gaussian prior.

Each group of unknowns x_g has a prior of mean 0 and standard deviation (width) s_g, which the
data set by the evidence; see docs/model.md. The lengths have, beside a width each, one common
change that the prior leaves nearly free: that of the robot's whole scale.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..data.observations import Observations
from .deflection import COMPLIANCE
from .extended_model import ExtendedModel

__all__ = ["PriorGroup", "prior_groups"]

BALL_WIDTH = 0.1
"""Prior of the ball's place on the flange [m]: hardly any."""
TRANSLATION_WIDTH, ROTATION_WIDTH = 1e-3, 5e-3
"""Where the widths of lengths [m] and angles [rad] begin."""
COMMON_SCALE = 2e-3
"""Prior of the scale of all lengths together: wide beside the 0.06 % that a caliper tells of a
50 mm base, so that measured distances rule, and narrow enough to hold where an arm is noisy."""
DEFLECTION = 5e-4
"""Where the widths of extensions begin, as an angle [rad]. Transmission errors much wider than
this are implausible, so it is the scale of the prior of their width, too."""
SMALLEST_WIDTH = 1e-12


@dataclass(frozen=True)
class PriorGroup:
    """Unknowns that share one prior, of mean 0 and width (standard deviation) s_g."""

    name: str
    unit: str
    members: np.ndarray
    """Their indices among the unknowns."""
    width: float
    """s_g; 0 holds the members at zero."""
    scale: float = np.inf
    """Of a half-normal prior on the width itself."""
    learned: bool = True
    """Whether the evidence sets the width."""
    effective: float = 0.0
    """gamma_g: how many of its unknowns the data decide."""
    common: np.ndarray | None = None
    """t: a change of all members in step that the prior allows beside the width, one standard
    deviation of it. For lengths, t is their change when the whole robot grows by 0.2 %."""

    def covariance(self, width: float) -> np.ndarray:
        """Return the members' prior covariance for a width: s_g^2 I + t t^T."""
        t = self._common
        return width**2 * np.eye(len(t)) + np.outer(t, t)

    def precision(self, members: np.ndarray, width: float) -> np.ndarray:
        """Return the prior precision (inverse covariance) of some of the members.

        Those left out are known to be zero. By Sherman and Morrison's formula,
        (s^2 I + t t^T)^-1 = (I - t t^T / (s^2 + t^T t)) / s^2.
        """
        t = self._common[np.isin(self.members, members)]
        return (np.eye(len(t)) - np.outer(t, t) / (width**2 + t @ t)) / width**2

    @property
    def _common(self) -> np.ndarray:
        return np.zeros(len(self.members)) if self.common is None else self.common

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, the uncertainty of its own width included.

        With a width learned from gamma unknowns integrated out, the prior is Student's with gamma
        degrees of freedom, whose variance is gamma / (gamma - 2) larger; twice at most here.
        """
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5 if self.learned else self.width

    def updated(self, x: np.ndarray, covariance: np.ndarray, members: np.ndarray) -> "PriorGroup":
        """Return the group after a fixed-point step of its width (MacKay 1992).

            gamma_g = tr(s_g^2 P_g) - tr(P_g Sigma_g P_g) s_g^2        s_g^2 = |x_g|^2 / gamma_g

        Args:
            x: Those members that are free.
            covariance: Sigma_g, their posterior covariance.
            members: Their indices.
        """
        P = self.width**2 * self.precision(members, self.width)
        effective = float(np.trace(P) - np.trace(P @ covariance @ P) / self.width**2)
        squares, gamma = float(np.sum((P @ x) ** 2)), max(effective, 1e-9)
        square = squares / gamma
        if np.isfinite(self.scale):
            h2 = self.scale**2
            square = h2 * (np.sqrt(gamma**2 + 4 * squares / h2) - gamma) / 2
        width = float(np.sqrt(max(square, SMALLEST_WIDTH**2)))
        return replace(self, width=width, effective=effective)


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
        own = np.arange(begin, begin + size)
        if extension == COMPLIANCE:
            torque = max(float(np.sqrt(np.mean(data.torques**2))), 1e-6)
            groups.append(PriorGroup(extension, "rad/(N m)", own, DEFLECTION / torque))
        else:
            groups.append(PriorGroup(extension, "rad", own, DEFLECTION, scale=DEFLECTION))
        begin += size
    return tuple(groups)

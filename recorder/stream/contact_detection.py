"""Detection of a hand that pushes the arm, from the joint torques of an arm at rest.

Torque beyond gravity, |tau - g| > 2 N m + 0.1 |g|, or a tremor of it; no capture is refused for it.
"""

from collections.abc import Callable, Sequence

from .stationarity import JointLimits, StationaryPose

LOAD = 2.0
"""Deviation from the gravity torque that is always allowed [N m]."""
LOAD_SHARE = 0.1
"""Further deviation that is allowed, as a share of the gravity torque."""
TREMOR = 4.0
"""A torque may tremble by this many times its tremor at the quietest rest."""
LEAST_TREMOR = 0.1
"""Standard deviation of a torque that is always allowed [N m]."""


class ContactDetector:
    """Compares each rest with gravity, and with the quietest rest before.

    ``gravity`` returns each joint's torque [N m] at joint positions; None where the model has no
    masses.
    """

    def __init__(
        self,
        joints: Sequence[JointLimits],
        gravity: Callable[[Sequence[float]], Sequence[float]] | None = None,
    ) -> None:
        self._joints = tuple(joints)
        self._gravity = gravity
        self._quietest: tuple[float, ...] | None = None

    def evidence(self, rest: StationaryPose) -> str | None:
        """Return the evidence that the arm is being pushed, in words; None without any."""
        if rest.effort is None or rest.effort_spread is None:
            return None
        return self._load(rest.position, rest.effort) or self._tremor(rest.effort_spread)

    def _load(self, position: Sequence[float], effort: Sequence[float]) -> str | None:
        if self._gravity is None:
            return None
        torques = self._gravity(position)
        for joint, tau, held in zip(self._joints, effort, torques, strict=True):
            if abs(tau - held) > LOAD + LOAD_SHARE * abs(held):
                return f"{joint.name} exerts {tau - held:+.1f} N m beyond gravity"
        return None

    def _tremor(self, spread: tuple[float, ...]) -> str | None:
        quietest = self._quietest or spread
        self._quietest = tuple([min(a, b) for a, b in zip(quietest, spread, strict=True)])
        for joint, now, quiet in zip(self._joints, spread, quietest, strict=True):
            if now > max(LEAST_TREMOR, TREMOR * quiet):
                return f"the effort of {joint.name} trembles by {now:.2f} N m"
        return None

"""Detector of a hand on a resting arm: efforts beyond gravity, or that tremble."""

from collections.abc import Callable, Sequence

from ...errors import fixed
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

    def evidence(self, pose: StationaryPose) -> str | None:
        """Return the evidence that the arm is being pushed, in words; None without any."""
        effort, spread = pose.effort, pose.effort_spread
        if effort is None or spread is None:
            return None
        torques = self._gravity(pose.position) if self._gravity else effort
        for joint, tau, torque in zip(self._joints, effort, torques, strict=True):
            if abs(tau - torque) > LOAD + LOAD_SHARE * abs(torque):
                return f"{joint.name} exerts {fixed(tau - torque, 1, '+')} N m beyond gravity"
        quietest = self._quietest or spread
        self._quietest = tuple(map(min, quietest, spread))
        for joint, now, quiet in zip(self._joints, spread, quietest, strict=True):
            if now > max(LEAST_TREMOR, TREMOR * quiet):
                return f"the effort of {joint.name} trembles by {now:.2f} N m"
        return None

"""Tells from measured efforts that someone pushes an arm which holds itself.

A hand that rests on the arm bends it a little, and its joint angles then do not say where an arm
without a hand would be. Two signs, looked at while the arm is still:

* *Load.* Where the model's link masses give the gravity torque, a joint that exerts something else
  by more than ``2 N m + 10 % of the gravity torque``: masses in models are some percent off, and a
  small tool is often missing.
* *Tremor.* An effort whose standard deviation over the window is over four times that of the
  quietest rest of this session, and over 0.1 N m: a hand is never quiet. The first rest has nothing
  to be compared with.

Both are hints and shown as such; a capture is not refused for them.
"""

from collections.abc import Callable, Sequence

from .rest import Rest
from .session import JointLimits

__all__ = ["Push"]

LOAD, LOAD_SHARE = 2.0, 0.1
TREMOR, LEAST_TREMOR = 4.0, 0.1


class Push:
    """Looks at rests, and remembers how quiet the sensors can be.

    Args:
        joints: The model's actuated joints.
        gravity: From joint positions to the torques that hold the arm [N m]; None without masses.
    """

    def __init__(
        self,
        joints: Sequence[JointLimits],
        gravity: Callable[[Sequence[float]], Sequence[float]] | None = None,
    ) -> None:
        self._joints = tuple(joints)
        self._gravity = gravity
        self._quietest: tuple[float, ...] | None = None

    def look(self, rest: Rest) -> str | None:
        """Say by which sign the arm is being pushed; None if nothing shows it."""
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

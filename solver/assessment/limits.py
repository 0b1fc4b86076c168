"""The largest errors that a calibration may have: sensible for each arm, and where they come from.

Errors of a calibrated arm stay within some three times its repeatability, which is how well it
comes back to the same place. A socket's centre is the mean of many samples, so the distance of two
is known better, and its limit is the repeatability itself. Play moves the samples of a socket
alike, and leaves the mean no better than each: of arms made of servos, the limit is twice that.
"""

from pathlib import Path

from ..results import Model
from .repeatability import ARMS, RESOLUTION, Arm, known_arm
from .types_report_verdict import Limit, Limits


def limits_for(
    model: Model,
    repeatability: float | None = None,
    *,
    mean_absolute_error: float | None = None,
    distance_error: float | None = None,
    between_placements: float | None = None,
    servos: bool = False,
) -> Limits:
    """Return the limits for an arm.

    Args:
        model: The robot's model in the calibration.
        repeatability: As the user says [m]; None for the one that is known of this arm.
        mean_absolute_error: Limit as the user says [m]; None, here and below, for a multiple of
            the repeatability.
        distance_error: Likewise, on the distance of two sockets.
        between_placements: Likewise, on distances between placements.
        servos: Whether it is made of servos, whose gears have play.
    """
    name = known_arm([model.name, Path(model.source).stem])
    if repeatability is not None:
        arm = Arm(repeatability, "given by --repeatability-mm")
    elif name is not None:
        arm = Arm(ARMS[name].repeatability, f"{name}: {ARMS[name].source}")
    else:
        arm = None
    return Limits(
        repeatability=None if arm is None else arm.repeatability,
        repeatability_source=arm.source if arm else "no repeatability is known for this arm",
        mean_absolute_error=_limit(arm, 3, mean_absolute_error, "--limit-mae-mm"),
        distance_error=_limit(arm, 2 if servos else 1, distance_error, "--limit-distance-mm"),
        between_placements=_limit(arm, 3, between_placements, "--limit-between-mm"),
    )


def _limit(arm: Arm | None, margin: int, given: float | None, option: str) -> Limit:
    if given is not None:
        return Limit(value=given, source=f"given by {option}")
    if arm is None:
        words = f"give --repeatability-mm (your arm's data sheet), or {option} to mukca report"
        return Limit(value=None, source=words)
    times = f"{margin} times the" if margin > 1 else "the"
    if arm.repeatability < RESOLUTION:
        words = f"{times} {1e3 * RESOLUTION:g} mm that a printed socket resolves"
    else:
        words = f"{times} arm's repeatability of {1e3 * arm.repeatability:g} mm"
    return Limit(value=margin * max(arm.repeatability, RESOLUTION), source=words)

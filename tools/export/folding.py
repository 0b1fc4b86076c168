"""The origins of a format that carries only some of the chain's joints."""

from collections.abc import Collection

import numpy as np

from .export import Request
from .transforms import origin_near, rigid


def folded_origins(request: Request, carried: Collection[str]) -> dict[str, np.ndarray]:
    """Return the origins that give the calibrated arm while all other joints stay nominal.

    What the fit changed at a joint that is not carried goes into the next one that is. Origins
    before which nothing else changed are returned as they are, to the last digit.

    Args:
        request: The export.
        carried: The joints whose origins can be changed; all that move are among them.

    Returns:
        x y z [m], roll pitch yaw [rad] of each carried joint, shape (6,).
    """
    origins: dict[str, np.ndarray] = {}
    change, changed = np.eye(4), False
    for joint, origin in zip(request.calibration.robot.joints, request.origins, strict=True):
        nominal = np.array(joint.origin.xyz + joint.origin.rpy)
        if joint.name in carried:
            folded = origin_near(change @ rigid(origin), nominal) if changed else origin
            origins[joint.name] = folded
            change, changed = np.eye(4), False
        elif changed or np.any(origin != nominal):
            change, changed = np.linalg.inv(rigid(nominal)) @ change @ rigid(origin), True
    return origins


def behind(request: Request, carried: Collection[str]) -> list[str]:
    """Return the joints behind the last carried one, whose changes have nowhere to go."""
    names = [joint.name for joint in request.calibration.robot.joints]
    return names[1 + max(i for i, name in enumerate(names) if name in carried) :]

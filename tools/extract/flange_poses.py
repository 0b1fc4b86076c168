"""Joint positions by poses of the nominal flange, as other programs keep them, where unique."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...recorder import Placement
from ...solver.calibration import Calibration, UsageError, pose_of_numbers

COLUMNS = tuple(f"flange_{name}" for name in ("x", "y", "z", "qx", "qy", "qz", "qw"))
"""Columns that stand in place of the joints: the flange in the base [m]."""
STARTS = 60
"""Postures from which each pose is sought."""
REACHED, SAME, APART = 1e-4, 1e-2, 0.5
"""Most that a pose leaves [m], [rad]; joints of one solution differ by less [rad]; and another that
is no farther from the posture than this beyond the nearest leaves the choice open [rad]."""


def joints_of(
    calibration: Calibration, views: Placement, near: Sequence[float] | None
) -> Placement:
    """Return views whose columns are :data:`COLUMNS` with joint positions in place of these poses.

    The joints stood nearest to the posture ``near``, shape (m,) [rad], where it is given.

    Raises:
        UsageError: Several postures, endlessly many or none bring the flange to a pose.
    """
    if views.joint_names is None or set(views.joint_names) != set(COLUMNS):
        return views
    robot, where = calibration.robot, str(views.files[0]) if views.files else views.name
    if (m := len(robot.joint_names)) > 6:
        raise UsageError(
            f"{where}: {m} joints bring a flange to one pose in endlessly many ways; record the "
            f"joints ({', '.join(robot.joint_names)}) in place of {COLUMNS[0]}, .."
        )
    order = [views.joint_names.index(name) for name in COLUMNS]
    poses = pose_of_numbers(np.array([s.position for s in views.samples])[:, order])
    on, generator = calibration.nominal.kinematics(), np.random.default_rng(0)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    starts = generator.uniform(lower, upper, (len(poses) * STARTS, m))
    targets, goal, _ = on.targets(np.repeat(poses, STARTS, axis=0))
    found = on.search(targets, goal, starts, None)
    samples = list(views.samples)
    for i, sample in enumerate(samples):
        rows = slice(i * STARTS, (i + 1) * STARTS)
        q = found.positions[rows][found.left[rows].max(axis=1) < REACHED]
        ways = _distinct(q)
        row = sample.where or f"view {i}"
        if not len(ways):
            raise UsageError(f"{row}: no posture within the limits brings the flange there")
        if near is not None:
            far = np.abs(ways - np.array(near)).max(axis=1)
            ways = ways[np.argsort(far)]
            if len(ways) == 1 or np.diff(np.sort(far))[0] > APART:
                ways = ways[:1]
        if len(ways) > 1:
            raise UsageError(
                f"{row}: {len(ways)} postures bring the flange there"
                + (
                    "; give one near which all views were taken (--near)"
                    if near is None
                    else ", several as near; record the joints"
                )
            )
        samples[i] = replace(sample, position=tuple(ways[0].tolist()))
    told = f"{where}: joints recovered from the flange's poses by the nominal model"
    return replace(
        views,
        samples=tuple(samples),
        joint_names=robot.joint_names,
        remarks=(*views.remarks, told),
    )


def _distinct(q: np.ndarray) -> np.ndarray:
    """Return each of some solutions once."""
    kept: list[np.ndarray] = []
    for row in q:
        if all(np.abs(row - other).max() > SAME for other in kept):
            kept.append(row)
    return np.array(kept)

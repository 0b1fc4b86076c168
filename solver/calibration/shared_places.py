"""Places that several robots share, and where ``arms.urdf`` puts each robot's base by them.

What a file holds is fitted for that file. The full models tell where bases stand. A bending arm's
rigid geometry has its errors in other places, so that its base fits best elsewhere.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..identification.data import IDENTITY, Measurement, Pose
from ..results import CalibratedRobot, rms

DEVIATIONS = np.repeat([0.01, 0.1], 3)
"""Standard deviations of a base's turn about the balls, and of its shift, before the fit [rad, m].

What the balls do not tell stays as the full model has it."""
ROUNDS = 3
SMALLEST = 1e-6
"""Error of a ball at least, per axis [m]."""

AtPlaces = dict[tuple[str, int], np.ndarray]
"""By frame, or base and socket: predicted ball and measured point of each sample, (N, 2, 3) [m]."""


def at_places(
    robot: CalibratedRobot, pose: Pose, data: Sequence[Measurement]
) -> AtPlaces:
    """Return predicted balls in the first robot's base beside what was measured."""
    samples: AtPlaces = {}
    for measured in data:
        balls = pose.apply(robot.predict(measured))
        points = np.zeros_like(balls)  # a socket is its own origin
        places = [(measured.placement.place, socket) for socket in measured.sockets]
        if measured.kind == "points":
            points = measured.points
            places = [(measured.frame, -1)]
        pairs = np.stack([balls, points], axis=1)
        for place, rows in zip(places, measured.slices, strict=True):
            before = samples.get(place, pairs[:0])
            samples[place] = np.concatenate([before, pairs[rows]])
    return samples


class FittedPose(NamedTuple):
    """A base as the rigid geometry needs it."""

    pose: Pose
    error: float
    """Distance of its balls from those of the full model, a root mean square [m]."""


def poses_for_urdf(
    robots: Mapping[str, CalibratedRobot],
    poses: Mapping[str, Pose],
    data: Mapping[str, Sequence[Measurement]],
) -> dict[str, FittedPose]:
    """Return where each base stands such that ``calibrated.urdf`` fits there.

    With balls p by the full model and p' by the URDF, at all samples of places that another robot
    shares, a base turns by r and moves by t, of the prior N(0, P), where they are least:

        sum |p - (R(r) (p' - c) + c + t)|^2 / s^2 + [r, t]^T P^-1 [r, t]

    with c the mean of p, and s^2 the mean square of what is left, per axis.
    """
    full = {
        name: at_places(robots[name], pose, data[name]) for name, pose in poses.items()
    }
    fitted: dict[str, FittedPose] = {}
    for name, pose in poses.items():
        places = [
            place
            for place in full[name]
            if sum(place in balls for balls in full.values()) > 1
        ]
        rigid = at_places(robots[name].geometric, pose, data[name])
        p, of_urdf = [
            np.concatenate([balls[place][:, 0] for place in places or balls])
            for balls in (full[name], rigid)
        ]
        fitted[name] = _moved(pose, of_urdf, p)
    return fitted


def _moved(pose: Pose, points: np.ndarray, targets: np.ndarray) -> FittedPose:
    """Return a pose after the motion of its points to their targets, shape (N, 3) [m]."""
    centre = Pose(np.eye(3), targets.mean(axis=0))
    inner, outer = centre.inverse().apply(points), centre.inverse().apply(targets)
    change = np.zeros(6)
    for _ in range(ROUNDS):
        motion = IDENTITY.moved(change)
        e = (outer - motion.apply(inner)).ravel()
        S = motion.slopes(inner).reshape(-1, 6)
        precision = 1 / max(np.mean(e**2), SMALLEST**2)
        H = precision * S.T @ S + np.diag(DEVIATIONS**-2)
        change = np.linalg.solve(H, precision * S.T @ (e + S @ change))
    motion = IDENTITY.moved(change)
    errors = np.linalg.norm(outer - motion.apply(inner), axis=1)
    return FittedPose(centre @ motion @ centre.inverse() @ pose, rms(errors))

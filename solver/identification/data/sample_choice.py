"""Samples that count: read, without whole turns, each once, none alone in its socket."""

from dataclasses import replace

import numpy as np

from ....errors import JOINT_POSITION
from ....recorder import Placement, distinct, require_near, without_turns
from ..robot import Robot
from .plausibility import with_steps_told, without_lost_rows


def counting(placement: Placement, robot: Robot, *, whole: bool) -> Placement:
    """Return the samples of a placement that count; all of them if it is ``whole``.

    Raises:
        RecordingError: A place is too far away for any arm.
    """
    require_near(placement)
    same_turns = unwound(placement, robot)
    if whole:
        return same_turns
    read = without_lost_rows(same_turns, robot)
    return counted_once(with_steps_told(read, robot))


def unwound(placement: Placement, robot: Robot) -> Placement:
    """Return the placement without whole turns that its joints' readings gained or lost.

    No encoder gains as many as degrees for radians seem to; these stay, to be refused.
    """
    turning = [joint.type != "prismatic" for joint in robot.actuated]
    if JOINT_POSITION.doubt(placement.positions[:, turning].ravel().tolist()):
        return placement
    return placement.with_positions(
        without_turns(placement.positions, robot.lower, robot.upper, turning)
    )


def counted_once(placement: Placement) -> Placement:
    """Return equal samples once; a socket that has no others is left as it is, to be refused."""
    counted = distinct(placement)
    counts = np.bincount(counted.sockets)
    before = np.bincount(placement.sockets)
    return placement if ((counts == 1) & (before > 1)).any() else counted


def without_single(placement: Placement, warnings: list[str]) -> Placement:
    """Leave out a socket's only sample, which tells nothing, where another socket has more."""
    counts = np.bincount(placement.sockets)
    single: list[int] = np.flatnonzero(counts == 1).tolist()
    if placement.kind == "points" or not single or counts.max() < 2:
        return placement
    warnings += [
        f"{placement.where}: socket {socket} has one sample, which is left out; "
        "at least 2 are needed"
        for socket in single
    ]
    samples = tuple(
        sample for sample in placement.samples if sample.socket not in single
    )
    return replace(placement, samples=samples)

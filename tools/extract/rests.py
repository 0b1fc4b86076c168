"""Finds where the arm rested, by the recorder's own rule."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...drivers import JointState
from ...recorder.session import STOOD_STILL, Session
from ...recorder.stream import JUMP, JointLimits, StationaryPose, StreamMonitor
from .log import Log


@dataclass(frozen=True)
class TimedRest:
    """One rest of the arm."""

    begin: float
    """When it was seen to be still [s], by the log's stamps."""
    end: float
    rest: StationaryPose
    """The average over the stillest window."""


def find_rests(
    log: Log, joints: Sequence[JointLimits], *, window: float, still: float
) -> list[TimedRest]:
    """Return the rests of an arm in the log's order, by the recorder's window [s] and stillness.

    A rest is what a recording by a key script would capture: the arm has been still for longer than
    a whole window, and nothing is wrong with the states. If they are missing for a while and the
    arm then stands where it stood, it is one rest.
    """
    watch = StreamMonitor(joints, window=window, still=still, live=False, resolution=log.resolution)
    same = Session(tuple(joints)).same
    rests: list[TimedRest] = []
    now: TimedRest | None = None
    for i in _slow_enough(log):
        stamp = float(log.stamps[i])
        effort = None if log.efforts is None else tuple(log.efforts[i].tolist())
        state = JointState(stamp, tuple(log.positions[i].tolist()), effort)
        looked = watch.feed(state, stamp, int(log.parts[i]))
        rest = watch.rest
        if rest is None or not looked:
            now = now if rest else None
            continue
        if not watch.settled or watch.trouble(stamp) is not None:
            continue
        if now is None or not same(now.rest.position, rest.position, STOOD_STILL):
            now = TimedRest(stamp - window, stamp, rest)
            if rests and same(rests[-1].rest.position, rest.position, STOOD_STILL):
                now = _joined(rests.pop(), now)
            rests.append(now)
        else:
            rests[-1] = now = _joined(now, TimedRest(stamp, stamp, rest))
    return rests


def _slow_enough(log: Log) -> list[int]:
    """Return the states but those at the beginning of a part in which the arm was already fast."""
    # The speed before the first state is not known, so the next one would look like a jump.
    begins = np.flatnonzero(np.diff(log.parts, prepend=log.parts[0] - 1))
    ends = [*begins[1:].tolist(), len(log.parts)]
    kept: list[int] = []
    for begin, end in zip(begins.tolist(), ends, strict=True):
        steps = np.abs(np.diff(log.positions[begin:end], axis=0)).max(axis=1, initial=0.0)
        slow = np.flatnonzero(steps < JUMP / 2)
        kept += range(begin + int(slow[0]), end) if len(slow) else []
    return kept


def _joined(first: TimedRest, second: TimedRest) -> TimedRest:
    """Return two rests at one place as one, with the stiller window of both."""
    stiller = min((first.rest, second.rest), key=lambda rest: max(rest.spread))
    return replace(first, end=second.end, rest=stiller)

"""Rests of an arm in a log by the rule of the recorder, and the sample of each.

The nominal model suggests socket and placement to some millimetres.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ...recorder import Placement, Sample, around, sample_files
from ...recorder.session import STOOD_STILL, Session
from ...recorder.stream import JUMP, JointLimits, StationaryPose, StreamMonitor
from ...solver.calibration import UsageError
from ...solver.identification.robot import Robot, nominal_balls
from .log import Log


@dataclass(frozen=True)
class Rest:
    """A rest of the arm, and the sample that it may be."""

    begin: float
    """When it was seen to be still [s], by the log's stamps."""
    end: float
    last: int
    """Index of the log's state at the end."""
    pose: StationaryPose
    """The average over the stillest window."""
    part: int = 0
    """The log's part, or episode, that it is in."""
    ball: tuple[float, ...] = ()
    """The ball's centre by the nominal model [m]."""
    placement: str | None = None
    """The placement's name; None where the rest is no sample."""
    socket: int = 0
    why: str = ""
    """The reason that it is none."""


@dataclass
class Stretch:
    """A stretch of a log in which nothing counts as a rest, since its states are not sound."""

    begin: float
    """[s], by the log's stamps."""
    end: float
    why: str
    part: int = 0
    """The log's part, or episode, that it is in."""

    @property
    def lasts(self) -> bool:
        """True where it is longer than what a lost state costs."""
        return self.end - self.begin > LASTS


LASTS = 2.0
"""Shorter stretches cost no rest [s]."""


def find_rests(
    log: Log,
    joints: Sequence[JointLimits],
    *,
    window: float,
    still: float,
    unsound: list[Stretch] | None = None,
) -> list[Rest]:
    """Return the rests of an arm in the log's order, by the recorder's window [s] and stillness.

    A rest is what a recording by a key script would capture: the arm has been still for longer than
    a whole window, and nothing is wrong with the states. If they are missing for a while and the
    arm then stands where it stood, it is one rest. Stretches whose states cannot be trusted are
    added to ``unsound``.
    """
    watch = StreamMonitor(
        joints, window=window, still=still, live=False, resolution=log.resolution
    )
    same = Session(tuple(joints)).same
    rests: list[Rest] = []
    stretches = [] if unsound is None else unsound
    for i in _slow_enough(log, joints):
        state = log.state(i)
        stamp, part = state.stamp, int(log.parts[i])
        looked = watch.feed(state, stamp, part)
        if why := watch.unsound(stamp):
            cause, *_ = why.split(";")
            _note(Stretch(stamp, stamp, cause, part), stretches)
        pose = watch.rest
        sound = watch.settled and watch.trouble(stamp) is None
        if not looked or not sound or pose is None:
            continue
        pause = Rest(stamp - window, stamp, i, pose, part)
        goes_on = rests and _goes_on(rests[-1], pause, log)
        if goes_on and same(rests[-1].pose.position, pose.position, STOOD_STILL):
            pause = _joined(rests.pop(), pause)
        rests.append(pause)
    return rests


def _goes_on(first: Rest, second: Rest, log: Log) -> bool:
    """Tell whether a rest may be the one before: not in another episode, nor at an earlier time."""
    same_part = first.part == second.part
    return same_part or (not log.episodes and first.end <= second.end)


def _note(moment: Stretch, stretches: list[Stretch]) -> None:
    """Lengthen the last stretch that is unsound for the same reason, or begin another."""
    last = stretches[-1] if stretches else Stretch(0.0, -math.inf, "")
    same = (last.why, last.part) == (moment.why, moment.part)
    if same and 0 <= moment.begin - last.end < LASTS:
        last.end = moment.end
    else:
        stretches.append(moment)


def _slow_enough(log: Log, joints: Sequence[JointLimits]) -> list[int]:
    """Return the states but those at the beginning of a part in which the arm was already fast."""
    # The speed before the first state is not known, so the next one would look like a jump.
    turning = [not joint.prismatic for joint in joints]
    steps = np.abs(around(np.diff(log.positions, axis=0), turning))
    largest = steps.max(axis=1, initial=0.0)
    ends = np.diff(log.parts) != 0
    slow_of_state = np.append((largest < JUMP / 2) & ~ends, False)
    states = np.arange(len(log.parts))
    slow_states: list[int] = []
    for part in np.split(states, np.flatnonzero(ends) + 1):
        first_slow = slow_of_state[part].argmax()  # 0 where none is
        slow_states += part[first_slow:].tolist()
    return slow_states


def _joined(first: Rest, second: Rest) -> Rest:
    """Return two rests at one place as one, with the stiller window of both."""
    poses = (first.pose, second.pose)
    stiller = min(poses, key=lambda pose: max(pose.spread))
    return replace(second, begin=first.begin, pose=stiller)


TOGETHER = 1 / 3
"""Balls nearer to each other than this share of the sockets' distance are in one socket."""
APART = 0.4
"""The distance of two sockets of a base comes out as measured, but for this share of it."""
LEAST = 4
"""Fewer rests at one place are no socket."""


def propose_samples(
    robot: Robot, rests: Sequence[Rest], joints: Sequence[JointLimits], distance: float
) -> list[Rest]:
    """Return rests with placements and sockets by the nominal model and the distance [m]."""
    if not rests:
        return []
    balls = nominal_balls(robot, np.array([pause.pose.position for pause in rests]))
    pairs = zip(rests, balls.tolist(), strict=True)
    proposed = [replace(pause, ball=tuple(ball)) for pause, ball in pairs]
    groups = _together(balls, TOGETHER * distance)
    sockets = [group for group in groups if len(group) >= LEAST]
    for number, pair in enumerate(_pairs(sockets, balls, distance), start=1):
        name = f"placement_{number}"
        for socket, group in enumerate(pair):
            for i in group:
                proposed[i] = replace(proposed[i], placement=name, socket=socket)
    return _usable(proposed, joints)


def _together(points: np.ndarray, within: float) -> list[list[int]]:
    """Return groups of points, each within a distance of another one of its group."""
    offsets = points[:, None] - points
    joined = np.linalg.norm(offsets, axis=2) <= within
    count = 0
    while count < joined.sum():
        count = joined.sum()
        ways = joined.astype(np.float32) @ joined
        joined = ways > 0
    firsts = np.unique(joined.argmax(axis=1))
    return [np.flatnonzero(joined[i]).tolist() for i in firsts]


def _pairs(
    groups: list[list[int]], balls: np.ndarray, distance: float
) -> list[list[list[int]]]:
    """Return the sockets of each base, the earlier first; the bases in order of time."""
    centres = [np.median(balls[group], axis=0) for group in groups]
    sockets = range(len(groups))
    mismatch = {
        (i, j): abs(math.dist(centres[i], centres[j]) - distance)
        for i, j in combinations(sockets, 2)
    }
    partner: dict[int, int] = {}
    for pair in sorted(mismatch, key=mismatch.__getitem__):
        if mismatch[pair] > APART * distance:
            break
        if partner.keys().isdisjoint(pair):
            i, j = pair
            partner[i], partner[j] = j, i
    bases = {tuple(sorted({i, partner.get(i, i)})) for i in sockets}
    return [[groups[i] for i in base] for base in sorted(bases)]


def _usable(rests: Sequence[Rest], joints: Sequence[JointLimits]) -> list[Rest]:
    """Return the rests, without a placement where the recorder would refuse them, and why."""
    sessions: dict[str, Session] = {}
    usable: list[Rest] = []
    for pause in rests:
        name = pause.placement
        if name is None:
            usable.append(replace(pause, why="not in a socket"))
            continue
        before = sessions.get(name, Session(tuple(joints), sockets=100))
        session = before.switched(pause.socket)
        why = session.refusal(pause.pose.position)
        usable.append(replace(pause, placement=None, why=why) if why else pause)
        if not why:
            sessions[name] = session.captured(session.sample_at(pause.pose))
    return usable


def assign(rests: Sequence[Rest], words: Sequence[str]) -> list[Rest]:
    """Return rests with placements and sockets that words as ``front:0=1-30`` give instead.

    A word is a placement, a socket, and the rests' numbers from 1, in ranges with commas between;
    rests that none names are left out. One that is none, has no rest, or names one twice is a
    UsageError.
    """
    assigned = [
        replace(pause, placement=None, socket=0, why="not assigned") for pause in rests
    ]
    for word in words:
        match = re.fullmatch(r"([\w.-]+):(\d)=(\d+(?:-\d+)?(?:,\d+(?:-\d+)?)*)", word)
        if not match:
            raise UsageError(
                f"--assign {word}: write PLACEMENT:SOCKET=RESTS, as in front:0=1-30"
            )
        name, socket, ranges = match.groups()
        for i in _indices(word, ranges, len(rests)):
            if assigned[i].placement:
                raise UsageError(f"--assign {word}: rest {i + 1} is assigned twice")
            assigned[i] = replace(rests[i], placement=name, socket=int(socket), why="")
    return assigned


def _indices(word: str, ranges: str, count: int) -> Iterator[int]:
    """Yield the indices of rests that ranges such as ``1-30,32`` name in a word."""
    for part in ranges.split(","):
        first, _, last = part.partition("-")
        if last and int(last) < int(first):
            raise UsageError(
                f"--assign {word}: {part} runs backwards; write {last}-{first}"
            )
        for number in range(int(first), int(last or first) + 1):
            if not 1 <= number <= count:
                raise UsageError(f"--assign {word}: the rests are 1 to {count}")
            yield number - 1


def placements_of(
    rests: Sequence[Rest], joint_names: Sequence[str], distance: float
) -> dict[str, dict[str, bytes]]:
    """Return the files of each placement, by its name."""
    samples: dict[str, list[Sample]] = {}
    for pause in rests:
        if pause.placement:
            sample = Session((), socket=pause.socket).sample_at(pause.pose)
            samples.setdefault(pause.placement, []).append(sample)
    joints = tuple(joint_names)
    return {
        name: sample_files(Placement(name, tuple(rows), joints, distance=distance))
        for name, rows in samples.items()
    }

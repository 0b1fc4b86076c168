"""A hand that leads the simulated arm to the pose and socket that a session asks for.

``mock:PATH?follow`` is an arm like that of the recording at PATH, beside its sockets. The hand
waits wherever the arm rests until that is captured, and then seats the ball at the proposed pose.
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from ...drivers import Driver, DriverError, match_joints
from ...drivers.arms import Mock, Motion, arm_at
from ...recorder import METADATA, read_sessions
from ...recorder.session import View
from ...solver.identification.robot import Robot, gravity_moments, nominal_balls
from ...solver.poses import InverseKinematics
from .demo import SEAT_NOISE
from .recordings import reachable_bases
from .session_faults import (
    Session,
    fitted_session,
    seated,
    session_faults,
    with_faults,
)

FOLLOW = "follow"
"""Word of a ``mock`` address that asks for such a hand."""
PRACTICE = "mock"
"""Driver of simulated arms: its address is a recording, not an arm's."""
CLOSE = 1e-4
"""A ball that comes this near to its seat is in it [m]."""
LOOSE = 4 * SEAT_NOISE
"""A recorded ball farther than this from its socket's centre is seated anew [m]."""


@dataclass(frozen=True)
class LedMotion(Motion):
    """A motion that waits at each rest until it is led on."""

    begun: list[float] = field(default_factory=list[float])
    """When each move began [s]."""

    def phase(self, time: float) -> tuple[int, float]:
        """Return the number of the last rest, and how far the move after it has come, 0 to 1."""
        count = bisect_right(self.begun, time)
        if not count:
            return 0, 0.0
        progress = (time - self.begun[count - 1]) / self.move
        return (count, 0.0) if progress >= 1 else (count - 1, progress)

    def begin(self, time: float) -> None:
        """Begin a move, after the one that is under way [s]."""
        ends = [begun + self.move for begun in self.begun[-1:]]
        self.begun.append(max([time, *ends]))


class FollowingHand:
    """Leads the arm at a ``mock`` address, in one run of the recorder.

    Args:
        address: The part after ``mock:``, without the word ``follow``. Faults of a session come to
            the poses that it leads to, by their numbers.
        robot: The nominal model.
        distance: Between the sockets [m]; None for that of the recording.

    Raises:
        DriverError: No such recording, or of another arm; or a fault that does not exist.
    """

    def __init__(
        self,
        address: str,
        robot: Robot,
        distance: float | None,
    ) -> None:
        motion_address, self._faults = session_faults(address)
        arm = arm_at(motion_address)
        names = match_joints(robot.joint_names, len(arm.joint_names), "the recording")
        order = list(range(len(names)))
        if sorted(arm.joint_names) == sorted(names):
            order = [arm.joint_names.index(name) for name in names]
        recorded = np.array(arm.motion.configurations)[:, order]
        path = Path(motion_address.partition("?")[0])
        beside = [q[:, order] for q in _recorded_beside(path, arm.joint_names)]
        self._session = fitted_session(recorded, robot, arm.seed, beside)
        self._has_efforts = arm.efforts is not None
        self.truth = self._session.robot
        """The arm that the hand leads."""
        self._seed = arm.seed
        self._generator = np.random.default_rng(arm.seed)
        self._reach = InverseKinematics(self.truth)
        first, second = self._session.centres
        recorded_distance = float(np.linalg.norm(second - first))
        self._distance = distance or recorded_distance
        along = (second - first) / recorded_distance
        second = first + self._distance * along
        self._sockets = np.array([first, second])
        self._led: list[np.ndarray] = []
        self._labels: list[int] = []
        self._rows_led = {0}
        self._poses = list[tuple[float, ...]]()
        self._efforts = list[list[float]]()
        socket = int(self._session.sockets[0])
        q = self._session.positions[0]
        (ball,) = nominal_balls(self.truth, q[None])
        if np.linalg.norm(ball - self._sockets[socket]) > LOOSE:  # noisy servos
            q = self._seated_at(q, socket)
        self._rest_at(q, socket)
        self._motion = LedMotion(self._poses, move=arm.motion.move)
        self._arm = replace(
            arm,
            motion=self._motion,
            joint_names=names,
            efforts=self._efforts if self._has_efforts else None,
        )
        self.guided = True
        """False where no guide proposes poses: they are the recording's then, in its order."""

    @property
    def rest(self) -> tuple[float, ...]:
        """Configuration in which the arm rests, or to which it is led [rad], [m]."""
        return self._poses[-1]

    def connection(self) -> Driver:
        """Connect to the arm."""
        return Mock(joint_names=self._arm.joint_names, arm=self._arm)

    def move_base(self) -> None:
        """Put the base elsewhere, within the arm's reach, for another placement."""
        (base,) = reachable_bases(self.truth, self._generator, 1, self._distance)
        self._sockets = np.array(base.sockets)
        self._rows_led |= set(range(len(self._session.positions)))
        self._lead(None, 0)

    def follow(self, view: View) -> None:
        """Lead the arm on, where its rest is captured or the ball belongs in another socket."""
        session = view.session
        number, _ = self._motion.phase(self._arm.now())
        arrived = number == len(self._motion.begun)
        if not arrived or view.alarm or view.question or session.finished:
            return
        if session.socket == self._labels[-1]:
            # There is nothing more to lead to in this socket, or the rest is not captured yet.
            done = session.turn_done or session.counts[session.socket] >= session.target
            is_same = partial(session.same, self.rest)
            if done or not any(is_same(sample.position) for sample in session.samples):
                return
        advice, count = view.advice, len(session.live)
        if self.guided and advice and advice.target:
            self._lead(np.array(advice.target), session.socket)
        elif not self.guided or not count or (advice and advice.count == count):
            self._lead(None, session.socket)  # else the guide is not ready yet

    def _lead(self, reference: np.ndarray | None, socket: int) -> None:
        """Begin a move to a pose with the ball in a socket; without one, where the hand likes."""
        rows = set(np.flatnonzero(self._session.sockets == socket).tolist())
        rows -= self._rows_led
        if rows and not self.guided:  # the recording's next sample in that socket
            self._rows_led.add(min(rows))
            q = self._session.positions[min(rows)]
        else:
            q = self._seated_at(reference, socket)
        self._rest_at(q, socket)
        # After the pose: another thread reads both.
        self._motion.begin(self._arm.now())

    def _rest_at(self, q: np.ndarray, socket: int) -> None:
        """Add a configuration, with its torques."""
        self._led.append(q)
        self._labels.append(socket)
        goal = q
        if self._faults:
            count = len(self._led)
            session = Session(
                self.truth,
                np.concatenate([self._led, self._session.positions[count:]]),
                np.concatenate([self._labels, self._session.sockets[count:]]),
                self._sockets,
                np.random.default_rng(self._seed),  # a fault stays as it was
            )
            goal = with_faults(session, self._faults)[count - 1]
        if self._has_efforts:
            (moments,) = gravity_moments(self.truth, goal[None])
            self._efforts.append(moments[: len(q)].tolist())
        self._poses.append(tuple(goal.tolist()))

    def _seated_at(self, reference: np.ndarray | None, socket: int) -> np.ndarray:
        """Return a configuration with the ball in a socket, near another if one is given."""
        noise = self._generator.normal(0, SEAT_NOISE, 3)
        seat = self._sockets[min(socket, 1)] + noise
        if reference is not None:
            (q,) = seated(self.truth, reference[None], seat[None])
            (ball,) = nominal_balls(self.truth, q[None])
            inside = (q >= self._reach.lower) & (q <= self._reach.upper)
            if inside.all() and np.linalg.norm(ball - seat) < CLOSE:
                return q
        (q,) = self._reach.reach(seat[None], self._generator)
        return q


def practice_bases(path: Path) -> list[Path]:
    """Return the folders of recordings beside one, each with its base; none of a practice."""
    folders = sorted({file.parent for file in path.parent.glob("*/*.csv")})
    return [folder for folder in folders if not _is_practice(folder)]


def _is_practice(folder: Path) -> bool:
    sessions = read_sessions(folder / METADATA)
    drivers = [str(session.get("driver", "")) for session in sessions]
    return any(driver.partition(":")[0] == PRACTICE for driver in drivers)


def _recorded_beside(path: Path, joint_names: Sequence[str]) -> Iterator[np.ndarray]:
    """Yield joint positions of the same joints in the folders beside one, shape (N, m)."""
    for folder in practice_bases(path) if path.is_dir() else ():
        with suppress(DriverError, OSError):
            arm = arm_at(str(folder))
            if folder != path and arm.joint_names == joint_names:
                yield np.array(arm.motion.configurations)


def following_hand(
    driver: str,
    robot: Robot,
    distance: float | None,
) -> FollowingHand | None:
    """Return the hand that ``mock:PATH?follow`` asks for; None for other drivers.

    Raises:
        DriverError: As :class:`FollowingHand`.
    """
    name, _, address = driver.partition(":")
    path, _, query = address.partition("?")
    words = query.split("&")
    if name != PRACTICE or FOLLOW not in words:
        return None
    words.remove(FOLLOW)
    return FollowingHand(
        "?".join([path, *filter(None, ["&".join(words)])]), robot, distance
    )

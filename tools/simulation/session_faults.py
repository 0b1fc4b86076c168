"""Faults of a recording session at a simulated arm, such as a base that is bumped.

A fault is ``KIND[@SAMPLE[+COUNT]][:SIZE]`` as in ``base@6:5mm``: from sample 6 on, for COUNT
samples where it is given, by so much. docs/simulated-arm.md lists them.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...drivers import Driver, Reason
from ...drivers.arms import Mock, arm_at
from ...recorder import Placement
from ...solver.diagnostics import FLAWS, RigidModel, SeatSamples, shift_by
from ...solver.identification.data import measure
from ...solver.identification.robot import (
    BallModel,
    Robot,
    all_parameters,
    nominal_balls,
)

APART = 0.03
"""Balls that lie farther apart than this were in two sockets [m]."""
STEPS = 6
"""Newton steps that follow a ball which is moved."""
LARGEST_STEP = 0.2
"""Change of a joint in one of them, at most [rad], [m]."""
_TEXT = re.compile(r"([a-z_]+)(?:@(\d+)(?:\+(\d+))?)?(?::([\d.]+)(mm|deg|%))?")
_UNITS = {"mm": 1e-3, "deg": math.radians(1), "%": 1e-2}


@dataclass(frozen=True)
class Session:
    """A session as it would be without its faults."""

    robot: Robot
    positions: np.ndarray
    """Joint positions of its samples in the order of recording, shape (N, m)."""
    sockets: np.ndarray
    """Number of the socket that each is labelled with, shape (N,)."""
    centres: np.ndarray
    """Of the sockets, shape (S, 3) [m]."""
    generator: np.random.Generator

    def aside(self, size: float) -> np.ndarray:
        """A random vector in space of some length."""
        return size * _unit(self.generator.normal(size=3))

    def by_cause(self, flaw: str, size: float) -> np.ndarray:
        """By how much a flaw moves the balls, by the columns of its cause, shape (N, 3) [m]."""
        placement = Placement.of_arrays(
            "session",
            self.positions,
            self.sockets,
            self.robot.joint_names,
        )
        measured = measure(placement, self.robot, sockets=1)
        return shift_by(self.robot, measured, flaw, size, self.generator)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)


def _turned_base(s: Session, size: float) -> np.ndarray:
    radius = s.centres[s.sockets] - s.centres[0]
    tangent = np.cross([0.0, 0.0, 1.0], radius)
    inwards = math.cos(size) - 1
    return math.sin(size) * tangent + inwards * radius


def _bent_ball(s: Session, size: float) -> np.ndarray:
    parameters = all_parameters(s.robot)
    place = [p.index for p in parameters if p.of_ball and p.unit == "m"]
    model = BallModel(s.robot, place)
    return model.linearise(model.nominal, s.positions).by_parameters @ s.aside(size)


def _lost_zero(s: Session, size: float) -> np.ndarray:
    _, joints = s.positions.shape
    model = BallModel(s.robot, [])
    linear = model.linearise(model.nominal, s.positions)
    return -size * linear.by_joints[:, :, joints // 2]


Shift = Callable[[Session, float], np.ndarray]
_KINDS: dict[str, tuple[float, Shift]] = {
    "base": (5e-3, Session.aside),
    "turn": (math.radians(3), _turned_base),
    "drift": (3e-3, Session.aside),
    "ball": (5e-3, lambda s, size: np.array([s.aside(size) for _ in s.sockets])),
    "bent": (3e-3, _bent_ball),
    "loose": (2e-3, lambda s, size: s.generator.normal(0, size, (len(s.sockets), 3))),
    "socket": (
        0.0,
        lambda s, _: s.centres[1 - s.sockets.clip(0, 1)] - s.centres[s.sockets],
    ),
    "distance": (2e-3, lambda s, size: size * _unit(s.centres[1] - s.centres[0])),
    "zero": (math.radians(1), _lost_zero),
}
"""Usual size [m, rad] of each kind, and by how much it moves the balls, shape (N, 3) or (3,) [m]:
those of the samples that it concerns; little by little in a drift, and those in socket 1 where the
distance is wrong. What else a flaw may be is made by the columns of its cause."""


@dataclass(frozen=True)
class SessionFault:
    """A fault of a session: its kind, the samples that it concerns, and its size."""

    kind: str
    start: int = 1
    """Number of the first sample, from 1."""
    count: int | None = None
    """Number of samples; None for all that follow."""
    size: float = 0.0
    """[m, rad]."""

    @classmethod
    def parse(cls, text: str) -> "SessionFault | None":
        """Return the fault that a text names; None where it is none of a session's."""
        kind = re.split(r"[@:]", text)[0]
        if kind not in FLAWS:
            return None
        unit = FLAWS[kind][0].unit or ""
        match = _TEXT.fullmatch(text)
        allowed = (unit, None) if kind in _KINDS else (unit,)
        if not match or match[5] not in allowed:
            size, example = (f"[:SIZE{unit}]", f":5{unit}") if unit else ("", "")
            raise ValueError(
                f"fault {text!r}: expected KIND[@SAMPLE[+COUNT]]{size}, "
                f"as in {kind}@6{example}"
            )
        _, start, count, number, _ = match.groups()
        if kind == "ball":
            count = count or 1
        size = float(number) * _UNITS[unit] if number else _KINDS[kind][0]
        return cls(kind, int(start or 1), int(count) if count else None, size)

    def shift(self, session: Session) -> np.ndarray:
        """Return by how much it moves the ball of each sample, shape (N, 3) [m]."""
        if self.kind in _KINDS:
            shifts = _KINDS[self.kind][1](session, self.size)
        else:
            shifts = session.by_cause(self.kind, self.size)
        numbers = np.arange(1, len(session.positions) + 1)
        last = np.inf if self.count is None else self.start + self.count
        share = ((numbers >= self.start) & (numbers < last)).astype(float)
        if self.kind == "distance":
            share = (session.sockets == 1).astype(float)
        elif self.kind == "drift":
            share = share.cumsum() / max(share.sum(), 1)
        return share[:, None] * shifts


def with_faults(session: Session, faults: Sequence[SessionFault]) -> np.ndarray:
    """Return the joint positions of a session with faults, which move the balls, shape (N, m).

    The joints follow by the least change.
    """
    q = session.positions
    balls = nominal_balls(session.robot, q)
    shifts = sum(fault.shift(session) for fault in faults)
    return seated(session.robot, q, balls + shifts)


def seated(
    robot: Robot,
    q: np.ndarray,
    balls: np.ndarray,
) -> np.ndarray:
    """Return the configurations near others, shape (N, m), with the balls elsewhere, (N, 3) [m]."""
    model = BallModel(robot, [])
    for _ in range(STEPS):
        linear = model.linearise(model.nominal, q)
        inverse = np.linalg.pinv(linear.by_joints, rcond=0.05)
        change = np.einsum("nij,nj->ni", inverse, balls - linear.points)
        q = q + change.clip(-LARGEST_STEP, LARGEST_STEP)
    return q


def fitted_session(
    q: np.ndarray, robot: Robot, seed: int, beside: Sequence[np.ndarray] = ()
) -> Session:
    """Return a session of recorded joint positions, shape (N, m), of an arm fitted to them.

    The sockets follow from where the balls lie. The fit includes joint positions recorded with
    the base elsewhere, ``beside`` these, so that sessions at all bases have the same arm.
    """
    bases = [q, *beside]
    labels = [2 * i + _sockets_of(robot, base) for i, base in enumerate(bases)]
    positions = np.concatenate(bases)
    seats = SeatSamples(
        positions, np.concatenate(labels), np.zeros((len(positions), 3))
    )
    arm = RigidModel(robot).fitted(seats)
    sockets = labels[0]
    balls = nominal_balls(arm, q)
    centres = [
        np.median(balls[sockets == socket], axis=0)
        for socket in range(sockets.max() + 1)
    ]
    two_centres = np.array([*centres, balls[0]])[:2]
    return Session(arm, q, sockets, two_centres, np.random.default_rng(seed))


def _sockets_of(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the socket of each of N joint positions, shape (N,)."""
    balls = nominal_balls(robot, q)
    distances: np.ndarray = np.linalg.norm(balls - balls[0], axis=1)
    return (distances > max(APART, 0.5 * distances.max())).astype(int)


def session_faults(address: str) -> tuple[str, list[SessionFault]]:
    """Return a ``mock`` address without faults of a session, and these.

    Raises:
        DriverError: A fault is wrongly written.
    """
    path, mark, query = address.partition("?")
    words: list[str] = []
    faults: list[SessionFault] = []
    for word in query.split("&"):
        fault = None
        if "fault=" in word:
            try:
                fault = SessionFault.parse(word.removeprefix("fault="))
            except ValueError as error:
                raise Reason.BAD_ADDRESS(f"mock:{address}: {error}") from None
        if fault is None:
            words.append(word)
        elif fault not in faults:
            faults.append(fault)
    query = "&".join(words)
    return f"{path}{mark}{query}", faults


def practice_driver(address: str, robot: Robot) -> Callable[[], Driver]:
    """Return a function that connects to the simulated arm at a ``mock`` address, with its faults.

    Its samples are the recording's, in their order. Faults move the ball by a model fitted to them:
    by the nominal one a sample moved to the other socket would miss it by millimetres. A fault
    wrongly written is a DriverError.
    """
    motion_address, faults = session_faults(address)
    names = robot.joint_names
    if not faults:
        return lambda: Mock(motion_address, names)
    arm = arm_at(motion_address)
    q = np.array(arm.motion.configurations)
    _, joints = q.shape
    if joints != len(names):
        return lambda: Mock(motion_address, names)  # which says what is wrong
    session = fitted_session(q, robot, arm.seed)
    led = with_faults(session, faults)
    arm.motion = replace(arm.motion, configurations=led.tolist())
    return lambda: Mock(joint_names=names, arm=arm)

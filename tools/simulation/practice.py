"""Practice without an arm: the demo, its arm, bases and hand; and faults of a session at the arm.

A fault, such as a base that is bumped, is ``KIND[@SAMPLE[+COUNT]][:SIZE]`` as in ``base@6:5mm``:
from sample 6 on, for COUNT samples where it is given, by so much. docs/simulation.md lists them.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...drivers import Driver, Reason
from ...drivers.arms import Mock, arm_at
from ...recorder import DEFAULT_DISTANCE, Placement, sample_files
from ...solver.data import measure
from ...solver.diagnostics import FLAWS, Flaw, RigidModel, Samples, shift_by
from ...solver.results import write_files
from ...solver.robot import (
    BallModel,
    Robot,
    all_parameters,
    gravity_moments,
    load_robot,
    nominal_balls,
)
from .recordings import Base, record
from .simulated_arms import perturb

APART = 0.03
"""Balls that lie farther apart than this were in two sockets [m]."""
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

    def by_cause(self, flaw: Flaw) -> np.ndarray:
        """By how much a flaw moves the balls, by the columns of its cause, shape (N, 3) [m]."""
        names = self.robot.joint_names
        placement = Placement.of_arrays("session", self.positions, self.sockets, names)
        measured = measure(placement, self.robot, sockets=1)
        return shift_by(self.robot, measured, flaw, self.generator)


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
    linear = model.linearise(model.nominal, s.positions)
    return linear.by_parameters @ s.aside(size)


def _lost_zero(s: Session, size: float) -> np.ndarray:
    joint = s.positions.shape[1] // 2
    model = BallModel(s.robot, [])
    linear = model.linearise(model.nominal, s.positions)
    return -size * linear.by_joints[:, :, joint]


def _other_socket(s: Session, _: float) -> np.ndarray:
    other = 1 - s.sockets.clip(0, 1)
    return s.centres[other] - s.centres[s.sockets]


def _longer_distance(s: Session, size: float) -> np.ndarray:
    return size * _unit(s.centres[1] - s.centres[0])


def _thrown_ball(s: Session, size: float) -> np.ndarray:
    return np.array([s.aside(size) for _ in s.sockets])


def _loose_ball(s: Session, size: float) -> np.ndarray:
    return s.generator.normal(0, size, (len(s.sockets), 3))


Shift = Callable[[Session, float], np.ndarray]
_KINDS: dict[str, tuple[float, Shift]] = {
    "base": (5e-3, Session.aside),
    "turn": (math.radians(3), _turned_base),
    "drift": (3e-3, Session.aside),
    "ball": (5e-3, _thrown_ball),
    "bent": (3e-3, _bent_ball),
    "loose": (2e-3, _loose_ball),
    "socket": (0.0, _other_socket),
    "distance": (2e-3, _longer_distance),
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
            raise ValueError(
                f"fault {text!r}: expected KIND[@SAMPLE[+COUNT]][:SIZE{unit}], as in base@6:5mm"
            )
        _, start, count, number, _ = match.groups()
        size = float(number) * _UNITS[unit] if number else _KINDS[kind][0]
        if count is None and kind == "ball":
            count = 1
        return cls(kind, int(start or 1), None if count is None else int(count), size)

    def shift(self, session: Session) -> np.ndarray:
        """Return by how much it moves the ball of each sample, shape (N, 3) [m]."""
        numbers = np.arange(1, len(session.positions) + 1)
        last = np.inf if self.count is None else self.start + self.count
        concerned = (numbers >= self.start) & (numbers < last)
        share = concerned.astype(float)
        if self.kind == "drift":
            share = share.cumsum() / max(share.sum(), 1)
        elif self.kind == "distance":
            share = (session.sockets == 1).astype(float)
        if self.kind in _KINDS:
            _, shift = _KINDS[self.kind]
            shifts = shift(session, self.size)
        else:
            shifts = session.by_cause(Flaw.parse(self.kind).of_size(self.size))
        return share[:, None] * shifts


def with_faults(session: Session, faults: Sequence[SessionFault]) -> np.ndarray:
    """Return the joint positions of a session with faults, which move the balls, shape (N, m).

    The joints follow by the least change.
    """
    q = session.positions
    shifts = sum(fault.shift(session) for fault in faults)
    return seated(session.robot, q, nominal_balls(session.robot, q) + shifts)


def seated(robot: Robot, q: np.ndarray, balls: np.ndarray) -> np.ndarray:
    """Return the configurations near others, shape (N, m), with the balls elsewhere, (N, 3) [m]."""
    model = BallModel(robot, [])
    for _ in range(6):
        linear = model.linearise(np.zeros(0), q)
        back = np.linalg.pinv(linear.by_joints, rcond=0.05)
        change = np.einsum("nij,nj->ni", back, balls - linear.points)
        q = q + change.clip(-0.2, 0.2)
    return q


def fitted_session(q: np.ndarray, robot: Robot, seed: int) -> Session:
    """Return a session of recorded joint positions, shape (N, m), of an arm fitted to them.

    The sockets follow from where the balls lie.
    """
    balls = nominal_balls(robot, q)
    distances: np.ndarray = np.linalg.norm(balls - balls[0], axis=1)
    apart = max(APART, 0.5 * float(distances.max()))
    sockets = (distances > apart).astype(int)
    samples = Samples(q, sockets, np.zeros_like(balls))
    arm = RigidModel(robot).fitted(samples)
    balls = nominal_balls(arm, q)
    centres = [np.median(balls[sockets == k], axis=0) for k in range(sockets.max() + 1)]
    two_centres = np.array([*centres, balls[0]])[:2]
    return Session(arm, q, sockets, two_centres, np.random.default_rng(seed))


def session_faults(address: str) -> tuple[str, list[SessionFault]]:
    """Return a ``mock`` address without faults of a session, and these.

    Raises:
        DriverError: A fault is wrongly written.
    """
    path, mark, query = address.partition("?")
    others: list[str] = []
    faults: list[SessionFault] = []
    for word in query.split("&"):
        try:
            fault = (
                SessionFault.parse(word.removeprefix("fault="))
                if "fault=" in word
                else None
            )
        except ValueError as error:
            raise Reason.BAD_ADDRESS(f"mock:{address}: {error}") from None
        if fault is None:
            others.append(word)
        elif fault not in faults:
            faults.append(fault)
    return f"{path}{mark}{'&'.join(others)}", faults


def practice_driver(address: str, robot: Robot) -> Callable[[], Driver]:
    """Return a function that connects to the simulated arm at a ``mock`` address, with its faults.

    Its samples are the recording's, in their order. Faults move the ball by a model fitted to them:
    by the nominal one a sample moved to the other socket would miss it by millimetres. A fault
    wrongly written is a DriverError.
    """
    motion_address, faults = session_faults(address)
    if not faults:
        return lambda: Mock(motion_address, robot.joint_names)
    arm = arm_at(motion_address)
    q = np.array(arm.motion.configurations)
    if q.shape[1] != len(robot.joint_names):
        # The mock says what is wrong.
        return lambda: Mock(motion_address, robot.joint_names)
    led = with_faults(fitted_session(q, robot, arm.seed), faults)
    arm.motion = replace(arm.motion, configurations=led.tolist())
    return lambda: Mock(joint_names=robot.joint_names, arm=arm)


DEMO_SEED = 2920
"""Such a draw is off by 20 mm at the median; with this seed it is 7 to 9 mm, as real arms are."""
ORIGIN_DEVIATION = (5e-3, 12e-3)
"""Standard deviation of the true origins from the nominal ones [m, rad]."""
TURN = 6
"""Samples in a socket before it is the other's turn."""
SEAT_NOISE = 5e-5
"""Standard deviation of the ball's seat, per axis [m]."""


def demo_arm(seed: int = DEMO_SEED, *, keep_size: bool = True) -> tuple[Robot, Robot]:
    """Return the nominal Panda and the demo arm as it truly is, of nominal size; or one like it."""
    nominal = load_robot("panda")
    generator = np.random.default_rng(seed)
    return nominal, perturb(nominal, generator, *ORIGIN_DEVIATION, keep_size=keep_size)


def demo_bases(distance: float = DEFAULT_DISTANCE) -> list[Base]:
    """Return the socket base [m] in front of the arm, and to its left and right."""
    along_y = np.array([0.0, 1.0, 0.0])
    places = {
        "front": (0.5, 0.0, 0.1),
        "left": (0.35, 0.4, 0.1),
        "right": (0.35, -0.4, 0.1),
    }
    return [
        Base(name, np.array(place), along_y, distance) for name, place in places.items()
    ]


def simulate_hand(folder: Path, keys: Path, distance: float) -> None:
    """Write the poses that a hand leads the demo arm to at each base, and the keys pressed.

    The sockets, so far apart [m], take turns by sixes, as ``mukca record`` asks for.
    """
    _, arm = demo_arm()
    generator = np.random.default_rng(0)
    for base in demo_bases(distance):
        led = record(arm, base, generator, noise=SEAT_NOISE)
        moments = gravity_moments(arm, led.positions)[:, : len(arm.actuated)]
        pairs = zip(led.samples, moments.tolist(), strict=True)
        loaded = [replace(sample, effort=tuple(effort)) for sample, effort in pairs]
        order = np.arange(len(loaded)).reshape(2, -1, TURN).swapaxes(0, 1).ravel()
        in_turns = replace(led, samples=tuple(loaded[i] for i in order))
        write_files(folder / base.name, sample_files(in_turns))
    write_files(keys.parent, {keys.name: b"a*6 s  " * 9 + b"a*6 q\n"})

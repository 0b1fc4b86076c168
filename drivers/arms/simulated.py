"""A simulated arm that replays configurations, and misbehaves on demand.

It moves through given configurations as a hand would lead a real arm
(:mod:`mukca.drivers.arms.hand_guided_motion`), adds encoder noise, and streams the result as
joint states. It knows
no kinematics, and models no friction, no tremor of the hand, no rounding by encoders, and no
jitter of the controller's clock.

Its address is ``PATH?option=value&...``. PATH is a CSV file of configurations, or a placement
folder; the options are

============  ========================================================================
rate          states per second of the arm's time (1000)
hold, move    how long each rest and each move lasts [s] (1, 1)
noise         standard deviation of the encoder noise [rad] (2e-5)
effort_noise  the same of the torque sensors' noise [N m] (0.02)
seed          seed of the noise (0)
speed         how much faster than real time the arm lives (1)
buffer        how much of the stream waits for a late reader [s]; older states are
              lost, and counted as missed (inf)
fault         ``KIND@START+DURATION`` [s], as in ``nan@3.5+0.2``; may be given several
              times; DURATION may be ``inf`` and is 0.5 s where it is left out
============  ========================================================================

and the faults are

==========  ==========================================================================
drop        the connection breaks, and cannot be made again before the fault is over
silent      the connection stands, but no states come
freeze      states keep coming with new stamps and the same old content
repeat      the last state comes again and again, stamp included
nan         the last joint is NaN
jump        the last joint is off by 0.2 rad
zeros       all joints are exactly zero, as from a controller that is not yet up
short       the last joint is missing
push        a hand pushes the arm: every effort is off by 5 N m, and trembles
==========  ==========================================================================
"""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import parse_qsl

from .. import Driver, DriverError, JointState, Reason, clock, match_joints
from .hand_guided_motion import Motion
from .replay import number, read_replay

FAULTS = ("drop", "silent", "freeze", "repeat", "nan", "jump", "zeros", "short", "push")


@dataclass(frozen=True)
class Fault:
    """One thing that goes wrong with the simulated arm, for a while."""

    kind: str
    """One of :data:`FAULTS`."""
    start: float
    """When it begins, by the arm's time [s]."""
    duration: float = 0.5
    """How long it lasts [s]; may be infinite."""

    @classmethod
    def parse(cls, text: str) -> "Fault":
        """Read ``KIND@START+DURATION``.

        Raises:
            ValueError: The text is no such thing.
        """
        kind, _, when = text.partition("@")
        start, _, duration = when.partition("+")
        if kind not in FAULTS:
            raise ValueError(f"fault {kind!r} is none of {', '.join(FAULTS)}")
        return cls(kind, float(start), float(duration or cls.duration))

    def active(self, moment: float) -> bool:
        """Tell whether it holds at a moment of the arm's time [s]."""
        return self.start <= moment < self.start + self.duration


@dataclass
class SimulatedArm:
    """An arm that moves from the first connection on, whether or not anyone is still connected."""

    motion: Motion
    """Where it goes, and when."""
    joint_names: tuple[str, ...] = ()
    """Names of the joints; joint1, joint2, ... where none are given."""
    efforts: Sequence[Sequence[float]] | None = None
    """Torque of each joint at each of the motion's configurations [N m], shape (configurations,
    joints); None for an arm without torque sensors."""
    rate: float = 1000.0
    """States per second of the arm's time [Hz]."""
    noise: float = 2e-5
    """Standard deviation of the encoder noise [rad]."""
    effort_noise: float = 0.02
    """Standard deviation of the torque sensors' noise [N m]."""
    seed: int = 0
    """Seed of the noise: the same seed gives the same noise."""
    speed: float = 1.0
    """How many seconds of the arm's time pass in one second."""
    buffer: float = math.inf
    """How much of the stream waits for a late reader [s]; older states are lost."""
    faults: Sequence[Fault] = ()
    """What goes wrong, and when."""

    def __post_init__(self) -> None:
        if not (self.rate > 0 and self.speed > 0 and self.noise >= 0 and self.buffer > 0):
            raise ValueError("rate, speed and buffer must be positive, and noise not negative")
        if not self.joint_names:
            count = len(self.motion.configurations[0])
            self.joint_names = tuple(f"joint{i + 1}" for i in range(count))
        self._random = random.Random(self.seed)  # noqa: S311 - noise, no secret
        self._started = math.nan
        self._frozen: JointState | None = None
        efforts = self.efforts
        self._effort = None if efforts is None else replace(self.motion, configurations=efforts)

    def connect(self) -> int:
        """Start the arm if it does not move yet; return the number of the next state."""
        if math.isnan(self._started):
            self._started = clock.now()
            return 0
        return math.ceil(self.now() * self.rate)

    def now(self) -> float:
        """The arm's time [s]; 0 before the first connection."""
        if math.isnan(self._started):
            return 0.0
        return (clock.now() - self._started) * self.speed

    def due(self, number: int) -> float:
        """When a state leaves the arm, on the host's monotonic clock [s]."""
        return self._started + number / (self.rate * self.speed)

    def shows(self, kind: str, moment: float) -> bool:
        """Tell whether a kind of fault shows at a moment of the arm's time [s]."""
        return bool(self.faults) and any(
            fault.kind == kind and fault.active(moment) for fault in self.faults
        )

    def state(self, moment: float) -> JointState:
        """Return what the arm sends at a moment of its time [s], with noise and faults."""
        if self._frozen is not None:
            if self.shows("freeze", moment):
                return replace(self._frozen, stamp=moment)
            self._frozen = None
        position = self._noisy(self.motion.position(moment), self.noise)
        effort = None
        if self._effort is not None:
            effort = self._noisy(self._effort.position(moment), self.effort_noise)
            if self.shows("push", moment):
                effort = tuple([tau + 5 + self._random.gauss(0, 0.5) for tau in effort])
        if not self.faults:
            return JointState(stamp=moment, position=position, effort=effort)
        state = JointState(moment, self._spoilt(position, moment), effort)
        if self.shows("freeze", moment):
            self._frozen = state
        return state

    def _noisy(self, values: tuple[float, ...], sigma: float) -> tuple[float, ...]:
        if sigma == 0:
            return values
        gauss = self._random.gauss
        return tuple([value + gauss(0.0, sigma) for value in values])

    def _spoilt(self, position: tuple[float, ...], moment: float) -> tuple[float, ...]:
        if self.shows("nan", moment):
            return (*position[:-1], math.nan)
        if self.shows("jump", moment):
            return (*position[:-1], position[-1] + 0.2)
        if self.shows("zeros", moment):
            return (0.0,) * len(position)
        return position[:-1] if self.shows("short", moment) else position


class Mock(Driver):
    """A connection to a simulated arm.

    It stands in for a robot in tests, in the demo, and while writing a program that reads robots.

    Args:
        address: ``PATH?option=value&...``, see the module's docstring; ignored where an arm is
            given.
        joint_names: The model's actuated joints, in chain order.
        arm: The arm to connect to, for use from Python.

    Raises:
        DriverError: BAD_ADDRESS for an address without a recording or with an option that does
            not exist; WRONG_ROBOT for another number of joints; UNREACHABLE during a drop.
    """

    # A connection that a fault ended can be made again: arms with such a fault are kept here by
    # their address, and go on moving until the next connection to the same address finds them.
    _left: dict[str, SimulatedArm] = {}  # noqa: RUF012 - shared on purpose

    def __init__(
        self,
        address: str = "",
        joint_names: Sequence[str] | None = None,
        *,
        arm: SimulatedArm | None = None,
    ) -> None:
        self._address = address
        self._arm = arm or self._left.pop(address, None) or _arm_at(address)
        self._names = self._arm.joint_names
        if joint_names is not None:
            self._names = match_joints(joint_names, len(self._names), "the recording")
        self._open = False
        if self._arm.shows("drop", self._arm.now()):
            self._leave()
            raise DriverError(Reason.UNREACHABLE, "the simulated arm does not answer")
        self._next = self._arm.connect()
        self._last: JointState | None = None
        self._open = True

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints: the model's where it is known, else the recording's own."""
        return self._names

    def read(self, timeout: float) -> JointState:
        """Return the next state, no sooner than the arm sends it; see :meth:`Driver.read`."""
        deadline = clock.now() + timeout
        while True:
            if not self._open:
                raise DriverError(Reason.UNREACHABLE, "the connection is closed")
            self._skip_lost()
            due = self._arm.due(self._next)
            now = clock.now()
            if due > now:
                clock.sleep(max(0.0, min(due, deadline) - now))
                if due > deadline:
                    raise DriverError(Reason.SILENT, f"no state came within {timeout:g} s")
            state = self._receive()
            if state is not None:
                return state

    def close(self) -> None:
        """End the connection; safe to call twice."""
        if self._open:
            self._open = False
            self._leave()

    def _leave(self) -> None:
        now = self._arm.now()
        if self._address and any(fault.active(now) for fault in self._arm.faults):
            self._left[self._address] = self._arm

    def _skip_lost(self) -> None:
        """Skip the states that no longer fit the buffer, as a socket drops them."""
        late = self._arm.now() - self._next / self._arm.rate - self._arm.buffer
        if late > 0:
            lost = math.ceil(late * self._arm.rate)
            self.missed += lost
            self._next += lost

    def _receive(self) -> JointState | None:
        moment = self._next / self._arm.rate
        self._next += 1
        if self._arm.shows("drop", moment):
            self.close()
            raise DriverError(Reason.UNREACHABLE, "the simulated arm dropped the connection")
        if self._arm.shows("silent", moment):
            return None
        if self._last is None or not self._arm.shows("repeat", moment):
            self._last = self._arm.state(moment)
        return self._last


def _arm_at(address: str) -> SimulatedArm:
    """Build the arm that an address describes."""
    path, _, query = address.partition("?")
    if not path:
        raise DriverError(
            Reason.BAD_ADDRESS, "mock needs a recording to replay, as in mock:data/front"
        )
    options = dict[str, float]()
    faults: list[Fault] = []
    known = ("rate", "hold", "move", "noise", "effort_noise", "seed", "speed", "buffer")
    try:
        pairs = parse_qsl(query.replace("+", "%2B"), True, strict_parsing=bool(query))
        for name, value in pairs:
            if name == "fault":
                faults.append(Fault.parse(value))
            elif name not in known:
                raise ValueError(f"option {name!r} is none of {', '.join((*known, 'fault'))}")
            elif (parsed := number(value)) is None:
                raise ValueError(f"option {name}: {value!r} is not a number")
            else:
                options[name] = parsed
        return _build(Path(path), options, faults)
    except ValueError as error:
        raise DriverError(Reason.BAD_ADDRESS, f"mock:{address}: {error}") from None


def _build(path: Path, options: dict[str, float], faults: list[Fault]) -> SimulatedArm:
    replay = read_replay(path)
    hold, move = options.pop("hold", Motion.hold), options.pop("move", Motion.move)
    return SimulatedArm(
        Motion(replay.configurations, hold=hold, move=move),
        joint_names=replay.joint_names,
        efforts=replay.efforts,
        seed=int(options.pop("seed", 0)),
        faults=faults,
        **options,
    )

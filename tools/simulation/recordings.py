"""Simulated recordings: a socket base within reach, and an arm that is guided to it.

A person's session is imitated: the ball sits in a socket, and the arm is guided to random
configurations within its limits, its last link tilted away from the vertical by as much as the
printed socket allows. What is written down are the joint positions that put the *true* ball there.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from ...recorder import Placement
from ...solver.calibration import UsageError, check_keywords
from ...solver.identification.data import Samples, check_distance
from ...solver.identification.effects import EFFECTS, EXTENSIONS
from ...solver.identification.model import Deflection
from ...solver.identification.robot import (
    BallModel,
    Robot,
    choose_parameters,
    gravity_moments,
)
from ...solver.poses import InverseKinematics, SimulationError
from ...solver.results import CalibratedRobot
from .simulated_arms import Imperfection, perturb

if TYPE_CHECKING:
    from typing_extensions import Unpack

FRICTION = 0.03
"""Under less torque than this a joint with play rests on either side [N m]."""


@dataclass(frozen=True)
class Base:
    """A socket base: its sockets' centres in the robot's base frame."""

    name: str
    centre: np.ndarray
    """Between sockets 0 and 1, shape (3,) [m]."""
    direction: np.ndarray
    """Unit vector from socket 0 to socket 1."""
    distance: float = 0.05
    """Between the sockets' centres [m]."""

    @property
    def sockets(self) -> tuple[np.ndarray, np.ndarray]:
        """The centres of sockets 0 and 1."""
        half = 0.5 * self.distance * self.direction
        return self.centre - half, self.centre + half


class SimulationOptions(TypedDict, total=False):
    """Options of :func:`simulate_recordings`; the values in brackets hold where one is left out.

    Every extension of the fit is one, with the size of its coefficients (0).
    """

    samples: int
    """Configurations in each of the two sockets (30)."""
    seed: int
    """Of all randomness (0). The same seed gives the same arm, whatever ``samples`` is."""
    translation: float
    """Standard deviation of the true joint origins from the model's (2e-3) [m]."""
    rotation: float
    """The same of the turn of each joint's frame about each of its axes (5e-3) [rad]."""
    noise: float
    """Standard deviation of the ball's place in its socket, per axis (5e-5) [m]."""
    compliance: float
    """Largest twist of a joint under load, each drawn evenly from zero up to this (0)
    [rad/(N m)]. Arms with harmonic drives have some 5e-5."""
    tilt: float
    """The same about the two axes across each joint's own (0); some 3e-5."""
    play: float
    """Largest turn of a joint to either side by backlash (0) [rad]; some 5e-3 in arms of servos.
    A joint rests on the side that its load turns it to; without load on either."""
    transmission: float
    """Standard deviation of each coefficient of the transmission error (0) [rad]; some 2e-4."""
    curves: float
    """Amplitude of each joint's error curve (0) [rad], with bumps every 15 degrees or so; some 3e-4
    on arms that have them."""
    distance: float
    """Between the centres of the two sockets (0.05) [m]."""
    warming: float
    """Rise of the arm's temperature at each placement (0) [K]; samples then keep theirs."""
    zeros: float
    """Standard deviation of each joint's zero (0) [rad]; some 0.05 in arms of servos."""


DEFAULTS: SimulationOptions = {
    "samples": 30,
    "seed": 0,
    "translation": 2e-3,
    "rotation": 5e-3,
    "noise": 5e-5,
    "distance": 0.05,
    "warming": 0.0,
    "zeros": 0.0,
}
LEAST = {"placements": 1, "samples": 2}
"""Least values of what cannot be as small as zero."""


def simulate_recordings(
    robot: Robot,
    placements: int = 3,
    **options: "Unpack[SimulationOptions]",
) -> tuple[CalibratedRobot, list[Placement]]:
    """Draw an arm that differs from its model, and record it at several placements.

    For studies in which the truth must be known, and to try things without a robot::

        truth, (train, *test) = mukca.simulate_recordings(robot, 3, seed=1)
        calibration = mukca.calibrate(robot, train, test=test)

    Args:
        robot: The nominal robot: what the model says.
        placements: Number of placements of the socket base, far from each other.
        options: ``samples`` in each socket (30), ``seed`` (0), the ``distance`` of the sockets
            (0.05) [m], ``noise`` of the ball (5e-5) [m], ``translation`` (2e-3) [m] and
            ``rotation`` (5e-3) [rad] of the joints' origins, their ``zeros`` (0) [rad],
            ``warming`` (0) [K], and the size of each extension of the fit (0).

    Returns:
        The true robot, whose ``ball(q)`` says where the ball really is, on an arm that bends to
        some 0.01 mm; and the placements.

    Raises:
        UsageError: A number or an option that cannot be.
        SimulationError: The arm reaches too few places for the base.
    """
    sizes = dict.fromkeys(EXTENSIONS, 0.0)
    settings: dict[str, Any] = {
        "placements": placements,
        **DEFAULTS,
        **sizes,
        **options,
    }
    check_keywords("simulate_recordings", options, ["placements", *DEFAULTS, *sizes])
    for name, value in settings.items():
        lowest = LEAST.get(name, 0)
        if not lowest <= value < np.inf:
            raise UsageError(f"{name} {value}: give a number of at least {lowest}")
    seed = settings["seed"]
    arms, places, hands = [np.random.default_rng([seed, k]) for k in range(3)]
    arm = perturb(
        robot,
        arms,
        settings["translation"],
        settings["rotation"],
        zeros=settings["zeros"] > 0,
    )
    distance = check_distance(settings["distance"])
    bases = reachable_bases(arm, places, placements, distance)
    deflection = _deflection(robot, arms, settings)
    how = Imperfection(settings["noise"], deflection, warming=settings["warming"])
    samples = settings["samples"]
    recorded = [
        record(arm, base, hands, samples=samples, imperfection=how) for base in bases
    ]
    return truth_of(robot, arm, deflection), recorded


def truth_of(robot: Robot, arm: Robot, deflection: Deflection) -> CalibratedRobot:
    """Return a simulated arm as a perfect calibration of its nominal robot would have it."""
    truth = CalibratedRobot(robot, choose_parameters(robot), deflection=deflection)
    return replace(truth, values=truth.model.parameters_at(arm.origins))


def _deflection(
    robot: Robot,
    generator: np.random.Generator,
    sizes: Mapping[str, float],
) -> Deflection:
    """Return the effects of such sizes, of extensions and zeros, without those of size zero."""
    joints = robot.joint_names
    drawn: dict[str, np.ndarray] = {}
    for effect in EFFECTS.values():
        size = sizes.get("zeros" if effect.zeros else effect.extension)
        if not size:
            continue
        if effect.random:
            coefficients = effect.random(len(joints), generator)
        else:  # drawn independently
            draw = (
                generator.random if effect.non_negative else generator.standard_normal
            )
            coefficients = draw(len(effect.coefficient_names(joints)))
        drawn[effect.name] = size * coefficients
    return Deflection(tuple(drawn), tuple(drawn.values()))


def record(
    arm: Robot,
    base: Base,
    generator: np.random.Generator,
    *,
    samples: int = 30,
    noise: float = 0.0,
    imperfection: Imperfection | None = None,
    guide: InverseKinematics | None = None,
) -> Placement:
    """Return a placement recorded with an arm of true kinematics, so many samples in each socket.

    The noise is that of the ball's seat, per axis [m], unless an imperfection has its own; without
    a guide the poses are random. A base out of reach is a SimulationError.
    """
    how = imperfection or Imperfection(noise)
    sockets = np.repeat([0, 1], samples)
    seats = np.array(base.sockets)[sockets]
    readings = lead(arm, seats, generator, how, guide)
    names = arm.joint_names
    T = how.temperatures(len(seats)) if how.warming else None
    return Placement.of_arrays(
        base.name,
        readings,
        sockets,
        names,
        temperatures=T,
        distance=base.distance,
    )


def lead(
    arm: Robot,
    seats: np.ndarray,
    generator: np.random.Generator,
    how: Imperfection,
    guide: InverseKinematics | None = None,
) -> np.ndarray:
    """Return what the encoders read, shape (N, m), with the ball in some seats, shape (N, 3) [m].

    Without a guide the poses are random; a seat out of the arm's reach is a SimulationError.
    """
    noise = how.noise * generator.normal(0, 1, seats.shape)
    seats = seats + noise
    true = (guide or InverseKinematics(arm)).reach(seats, generator)
    moments = gravity_moments(arm, true, how.gravity)
    N, m = true.shape
    clocks = np.zeros((N, 3))
    clocks[:, 0] = np.arange(N)
    clocks[:, 2] = how.temperatures(N)
    samples = Samples(true, moments, clocks)
    if how.deflection.tilts:
        samples = _seated(arm, seats, samples, how.deflection)
    true = readings = samples.q
    for _ in range(8):  # contracts by the slope of the deflection, some 1e-3, each time
        samples = replace(samples, q=readings)
        believed = how.deflection.true_positions(samples)[:, :m]
        readings = true - (believed - readings)
    torques = samples.torques
    either = generator.choice([-1.0, 1.0], readings.shape)
    side = np.where(abs(torques) > FRICTION, np.sign(torques), either)
    readings = readings + 0.5 * how.play * side
    for effect in how.deflection.effects:
        if effect.joint_noise:  # where the load does not hold it to one side
            shares = effect.joint_noise(torques) * either
            readings = readings + how.deflection.by_name[effect.name] * shares
    if how.resolution == 0:
        return readings
    return how.resolution * np.round(readings / how.resolution)


def _seated(
    arm: Robot,
    seats: np.ndarray,
    samples: Samples,
    deflection: Deflection,
) -> Samples:
    """Return samples whose true joint positions put the ball into its seat, though joints tilt."""
    model = BallModel(arm, [])
    m = samples.q.shape[1]
    # Each step leaves some 1e-3 of the millimetre that tilts move the ball by.
    for _ in range(3):
        tilts = deflection.true_positions(samples)[:, m:]
        turned = np.hstack([samples.q, tilts])
        linear = model.linearise(np.empty(0), turned)
        back = np.linalg.pinv(linear.by_joints[:, :, :m])
        change = np.einsum("nij,nj->ni", back, seats - linear.points)
        samples = replace(samples, q=samples.q + change)
    return samples


def reachable_bases(
    robot: Robot,
    generator: np.random.Generator,
    count: int,
    distance: float = 0.05,
) -> list[Base]:
    """Return places for the base that are spread over an arm's workspace and within its reach.

    They stand on a table at the height of the robot's base or up to a quarter of its reach above,
    each far from those before.

    Raises:
        SimulationError: No such places were found.
    """
    guide = InverseKinematics(robot)
    lengths: np.ndarray = np.linalg.norm(robot.origins[:, :3], axis=1)
    reach = float(lengths.sum())
    bases: list[Base] = []
    for _ in range(400):
        radius = generator.uniform(0.35, 0.65) * reach
        angle = generator.uniform(-2.0, 2.0)
        height = generator.uniform(0.0, 0.25) * reach
        centre = radius * horizontal(angle) + [0.0, 0.0, height]
        direction = horizontal(generator.uniform(-np.pi, np.pi))
        base = Base(f"placement_{len(bases)}", centre, direction, distance)
        distances = [np.linalg.norm(centre - other.centre) for other in bases]
        if all(distance > 0.2 * reach for distance in distances):
            # Several ways lead there, as a person would see.
            with suppress(SimulationError):
                guide.reach(np.repeat(base.sockets, 5, axis=0), generator, rounds=2)
                bases.append(base)
        if len(bases) == count:
            return bases
    raise SimulationError(
        f"{robot.name}: found {len(bases)} of {count} places for the base"
    )


def horizontal(angle: float) -> np.ndarray:
    """Return the unit vector at an angle from x [rad], shape (3,)."""
    return np.array([np.cos(angle), np.sin(angle), 0.0])

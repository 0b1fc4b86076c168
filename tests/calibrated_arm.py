"""A simulated arm, its calibration, and what it would record since; and two arms face to face."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from worlds import recorded_by_both

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import Pose
from mukca.solver.identification.robot import BallModel, turn
from mukca.solver.results import CalibratedRobot
from mukca.tools.simulation import Base, Imperfection, reachable_bases, record


def pose_at(rotation_vector, place):
    """Return a pose by its turn [rad] and its place [m]."""
    return Pose(turn(np.array(rotation_vector)), np.array(place))


def pose_of(origin):
    """Return an origin of a URDF as a pose."""
    return Pose.of(origin)


HOME = Pose(np.eye(3), np.zeros(3))
FACING = pose_at([0.0, 0.0, np.pi], [1.2, 0.0, 0.0])
BASES = [
    Base("front", np.array([0.6, 0.0, 0.15]), np.array([1.0, 0.0, 0.0])),
    Base("left", np.array([0.55, 0.35, 0.3]), np.array([np.cos(1), np.sin(1), 0.0])),
]
"""Where two arms stand face to face, and the bases that both visit."""


def balls_of(arm, q):
    """Where a stiff arm has its ball, shape (N, 3) [m]."""
    return BallModel(arm, ()).points(np.zeros(0), q)


def with_ball(arm, place):
    """Return an arm whose ball sits elsewhere on its last link [m]."""
    origins = arm.origins.copy()
    origins[-1, :3] = place
    return arm.with_origins(origins)


def recorded_face_to_face(arms, generator, samples=8, noise=0.0):
    """Return what each of two arms recorded at the bases, a list of placements for each."""
    poses = [HOME, FACING]
    return recorded_by_both(arms, poses, BASES, generator, samples=samples, noise=noise)


@dataclass(frozen=True)
class Simulated:
    """An arm whose truth is known, calibrated at two bases, and recorded at a third."""

    truth: CalibratedRobot
    """Predicts where the ball truly is."""
    calibration: mukca.Calibration
    later: Placement
    """Recorded since, joints in order, 8 samples in each socket."""

    @property
    def first_base(self):
        """The first base that it was calibrated at."""
        first = self.calibration.document.data[0]
        balls = self.truth.ball([s.position for s in first.samples])
        sockets = np.array([s.socket for s in first.samples])
        a, b = (balls[sockets == k].mean(axis=0) for k in (0, 1))
        length = float(np.linalg.norm(b - a))
        return Base(first.name, (a + b) / 2, (b - a) / length, length)

    def touched(self, tip, count=10, seed=0, base=None):
        """Return touches of one fixed point by a tip on the flange [m], to 0.05 mm."""
        generator = np.random.default_rng(seed)
        arm = self.with_tip(tip)
        base = base or reachable_bases(arm, np.random.default_rng(1), 1)[0]
        how = Imperfection(5e-5, self.truth.deflection)
        q = record(arm, base, generator, samples=count, imperfection=how).positions[:count]
        return Placement.of_arrays("touches", q, [0] * count, arm.joint_names)

    def touched_at_two(self, tip, distance):
        """Return 4 touches of each of two points by a tip on the flange, so far apart [m]."""
        arm = self.with_tip(tip)
        (base,) = reachable_bases(arm, np.random.default_rng(1), 1)
        how = Imperfection(5e-5, self.truth.deflection)
        wide = replace(base, distance=distance)
        return record(arm, wide, np.random.default_rng(0), samples=4, imperfection=how)

    def recorded_by(self, arm):
        """Return samples of an arm, 6 in each socket of another base."""
        (base,) = reachable_bases(arm, np.random.default_rng(1), 1)
        how = Imperfection(5e-5, self.truth.deflection)
        return record(arm, base, np.random.default_rng(2), samples=6, imperfection=how)

    def with_tip(self, tip):
        """Return the true arm, its ball at a tip on the flange [m]."""
        arm = self.truth.robot.with_origins(self.truth.model.origins(self.truth.values))
        return with_ball(arm, tip)

    def read(self, offsets):
        """Return the later placement, read by joints whose zeros are off [rad]."""
        q = self.later.positions.copy()
        for joint, offset in offsets.items():
            q[:, joint] -= offset
        return Placement.of_arrays(
            "since", q, self.later.sockets, self.later.joint_names, distance=0.05
        )


@cache
def simulate():
    """Return the arm; the same each time."""
    robot = mukca.load_robot("panda")
    flaws = {"compliance": 4e-5, "tilt": 2e-5}
    truth, (*train, later) = mukca.simulate_recordings(robot, 3, seed=3, samples=16, **flaws)
    calibration = mukca.calibrate(robot, train)
    own = np.r_[0:8, 16:24]
    few = Placement.of_arrays(
        "later", later.positions[own], later.sockets[own], later.joint_names, distance=0.05
    )
    return Simulated(truth, calibration, few)

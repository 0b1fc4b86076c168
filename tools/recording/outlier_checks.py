"""Checks of samples by nominal models: outliers, a wrong model, and gravity."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from ...recorder import Sample
from ...solver.data import Load
from ...solver.robot import BallModel, Robot, gravity_torques, load_robot, shipped_robots

ENOUGH = 5
"""Samples in a socket before one of them can be called an outlier by :data:`FAR`."""
FAR, FAR_SHARE = 0.025, 4.0
"""An outlier is this far from the others [m], and so many times as far as they usually are."""
FIRST_FAR = 0.06
"""With fewer samples, one is an outlier that is this far from them [m]."""
FIRST_POSES = 3
"""Poses in a socket that show a wrong model."""
WRONG_SCATTER, WRONG_RATIO = 0.06, 4.0
"""By the model of another arm, the ball of one socket scatters by more than this [m], and so many
times as far as by the right one."""
SLACK = 0.05
"""Tolerance of the joints' limits [rad]."""


def gravity_of(
    robot: Robot, load: Load | None = None
) -> Callable[[Sequence[float]], Sequence[float]] | None:
    """Return the gravity torque as a function of the joint positions; None without masses."""
    if not robot.bodies:
        return None
    load = load or Load()

    def gravity(position: Sequence[float]) -> Sequence[float]:
        torques = gravity_torques(robot, np.array([position]), load.gravity, load.payload)
        return torques[0].tolist()

    return gravity


class OutlierCheck:
    """Check of the last of some samples by the nominal model.

    By it the ball's centres of one socket lie within a few millimetres up to some 20 mm, and those
    of the other socket as far away as the sockets are apart.

    Args:
        robot: The nominal robot.
        distance: Between the sockets' centres [m].
        far: An outlier among enough samples is this far from the others [m].
    """

    def __init__(self, robot: Robot, distance: float, far: float = FAR) -> None:
        self._robot = robot
        self._distance = distance
        self._far = far
        self._model = BallModel(robot, [])
        self._points: dict[int, np.ndarray] = {}

    def __call__(self, samples: Sequence[Sample]) -> str | None:
        """Return its oddity, in words that follow its name; None if nothing is odd."""
        last = samples[-1]
        point = self._ball(last, last=True)
        here = [self._ball(s, last=False) for s in samples[:-1] if s.socket == last.socket]
        there = [self._ball(s, last=False) for s in samples[:-1] if s.socket != last.socket]
        allowed = FIRST_FAR
        if len(here) + 1 >= ENOUGH:
            centre = np.median(here, axis=0)
            usual = float(np.median(np.linalg.norm(np.array(here) - centre, axis=1)))
            allowed = max(self._far, FAR_SHARE * usual)
        from_where = f"the others of socket {last.socket}"
        if not here and there:
            from_where = "the other socket"
            allowed += self._distance
        if not here and not there:
            return None
        away = float(np.linalg.norm(point - np.median(here or there, axis=0)))
        if away <= allowed:
            return None
        return (
            f"puts the ball {1e3 * away:.0f} mm from {from_where}: is it seated, and in socket "
            f"{last.socket}?"
        )

    def _ball(self, sample: Sample, last: bool) -> np.ndarray:
        """Return the ball's centre [m], computed once for each sample: the stream must not wait."""
        if last or sample.number not in self._points:
            point = self._model.points(np.zeros(0), np.array([sample.position]))[0]
            self._points[sample.number] = point
        return self._points[sample.number]


def wrong_model_check(robot: Robot) -> Callable[[Sequence[Sample]], str | None]:
    """Return a check, of seconds, for another robot that some poses fit far better than a model."""
    own_model = BallModel(robot, [])

    def check(samples: Sequence[Sample]) -> str | None:
        q = np.array([s.position for s in samples if s.socket == samples[-1].socket])
        if len(q) < FIRST_POSES or (own := _scatter(own_model, q)) < WRONG_SCATTER:
            return None
        scatters = {
            other.name: _scatter(BallModel(other, []), q) for other in _shipped(len(robot.actuated))
        }
        best = min(scatters, key=lambda name: scatters[name], default=None)
        if best is None or scatters[best] > own / WRONG_RATIO or best == robot.name:
            return None
        return (
            f"this moves like a {best}: by its model the ball of one socket scatters by "
            f"{1e3 * scatters[best]:.0f} mm, by that of {robot.name} by {1e3 * own:.0f} mm. Is "
            "--robot right?"
        )

    return check


def similar_models(robot: Robot) -> Callable[[Sequence[float]], str | None]:
    """Return a function that names the other shipped robots that reach a configuration."""

    def similar(position: Sequence[float]) -> str | None:
        names = [
            other.name
            for other in _shipped(len(robot.actuated))
            if other.name != robot.name
            and all(
                joint.lower - SLACK <= value <= joint.upper + SLACK
                for joint, value in zip(other.actuated, position, strict=True)
            )
        ]
        return " or a ".join(names) or None

    return similar


@lru_cache(maxsize=8)
def _shipped(joints: int) -> tuple[Robot, ...]:
    """Return the shipped robots with so many joints."""
    robots = [load_robot(name) for name in shipped_robots()]
    return tuple(robot for robot in robots if len(robot.actuated) == joints)


def _scatter(model: BallModel, q: np.ndarray) -> float:
    """Return the ball's mean distance from its mean position over some configurations [m]."""
    points = model.points(np.zeros(0), q)
    away: np.ndarray = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return float(away.mean())

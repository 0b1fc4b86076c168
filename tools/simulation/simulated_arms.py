"""Simulated arms whose true kinematics are known, with imperfections as real arms have them."""

from dataclasses import dataclass, field

import numpy as np

from ...solver.identification.effects import effects_of
from ...solver.identification.model import Deflection, extend
from ...solver.identification.robot import (
    STANDARD_GRAVITY,
    Robot,
    choose_parameters,
    matrix_rpy,
    rpy_axes,
)


@dataclass(frozen=True)
class Imperfection:
    """Imperfections of an arm and of its recording."""

    noise: float = 0.0
    """Standard deviation of the ball's seat, per axis [m]."""
    deflection: Deflection = field(default_factory=Deflection)
    """Elasticity and transmission error."""
    play: float = 0.0
    """Full play of each joint [rad], which rests on the side that gravity turns it to."""
    resolution: float = 0.0
    """Of the encoders [rad]; 0 for none."""
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    """In the base frame [m/s^2]."""
    warming: float = 0.0
    """Rise of its temperature from a placement's first sample to its last [K]."""

    def temperatures(self, samples: int) -> np.ndarray:
        """Return the temperature above the first of so many samples, shape (samples,) [K]."""
        rise: np.ndarray = np.linspace(0.0, self.warming, samples)
        return rise


def perturb(
    robot: Robot,
    generator: np.random.Generator,
    translation: float,
    angle: float,
    *,
    keep_size: bool = True,
    zeros: bool = False,
) -> Robot:
    """Return an arm like the nominal one, its actuated joints' and ball's origins a little off.

    ``translation`` is the standard deviation of x, y, z [m], ``angle`` that of the turn of a frame
    about each of its axes [rad].
    Real arms keep the nominal size: links are machined to better than 0.1 %, while such draws
    differ by up to 2 %. With ``zeros``, as of servos, that is the size beside the joints' zeros.
    """
    parameters = choose_parameters(robot)
    model = extend(robot, parameters, effects_of(zeros=zeros))
    widths = [translation if p.unit == "m" else angle for p in parameters]
    changes = generator.normal(0, 1, len(widths)) * widths
    joints = np.array([p.joint if p.unit == "rad" else "" for p in parameters])
    for joint in robot.joints:
        turned = joints == joint.name
        if turned.any():
            # Axes at right angles, near those of roll, pitch and yaw: a seed then draws nearly the
            # arm that it drew by these, which have such axes where the pitch is zero.
            rpy = joint.origin.rpy
            U, _, Vt = np.linalg.svd(matrix_rpy(rpy).T @ rpy_axes(rpy))
            changes[turned] = U @ Vt @ changes[turned]
    values = model.ball.nominal + changes
    by_scale = model.by_scale()[: len(parameters)]
    links = np.array([p.unit == "m" and not p.of_ball for p in parameters])
    for _ in range(4 if keep_size else 0):  # fixed joints keep their lengths
        larger = float(by_scale @ (values - model.ball.nominal))
        values[links] *= 1 - larger
    return robot.with_origins(model.ball.origins(values))

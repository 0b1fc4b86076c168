"""Joint origins as transforms, for formats that carry only some of them, and the cost of that."""

import math
from collections.abc import Collection, Sequence

import numpy as np

from ...solver.bayes.results import angles_near
from ...solver.data import Pose, kabsch, turn
from ...solver.robot import Origin
from .request import Loss, Request


def rigid(origin: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the transform of a URDF origin: x y z [m], roll pitch yaw [rad]."""
    return Pose.of(Origin.of(origin)).matrix


def to_axis(axis: Sequence[float]) -> np.ndarray:
    """Return the smallest turn that carries the z axis to another axis."""
    x, y, z = axis
    sine = math.hypot(x, y)
    if sine < 1e-12:
        return np.diag([1.0, math.copysign(1, z), math.copysign(1, z), 1.0])
    T = np.eye(4)
    T[:3, :3] = turn(np.array([-y, x, 0.0]) * (math.atan2(sine, z) / sine))
    return T


def redistributed_origins(request: Request, carried: Collection[str]) -> dict[str, np.ndarray]:
    """Return origins, shape (6,), of some joints, which take the changes of those before them."""
    origins: dict[str, np.ndarray] = {}
    change, changed = np.eye(4), False
    for joint, origin in zip(request.calibration.robot.joints, request.origins, strict=True):
        nominal = np.array(joint.origin.xyz + joint.origin.rpy)
        if joint.name in carried:
            origins[joint.name] = origin
            if changed:
                T = change @ rigid(origin)
                angles = angles_near(T[:3, :3], nominal[3:])
                origins[joint.name] = np.concatenate([T[:3, 3], angles])
            change, changed = np.eye(4), False
        elif changed or np.any(origin != nominal):
            change, changed = np.linalg.inv(rigid(nominal)) @ change @ rigid(origin), True
    return origins


def after_last_exported(request: Request, carried: Collection[str]) -> list[str]:
    """Return the joints after the last carried one, whose changes no origin can take."""
    names = [joint.name for joint in request.calibration.robot.joints]
    return names[1 + max(i for i, name in enumerate(names) if name in carried) :]


def losses_without(request: Request, uncarried: Collection[str] = ()) -> tuple[Loss, ...]:
    """Return what a format leaves out, which cannot change the origins of some joints."""
    calibrated, robot = request.calibration.calibrated, request.calibration.robot
    q = np.concatenate([[s.position for s in d.samples] for d in request.calibration.document.data])
    geometric = calibrated.geometric_ball(q)
    losses: list[Loss] = []
    if calibrated.deflection.extensions:
        words = "corrections of the joints (" + ", ".join(calibrated.deflection.extensions) + ")"
        # Where an arm's base frame stands is not measured: a shift or turn of all is no loss.
        ball = calibrated.ball(q)
        losses.append(_loss(words, kabsch(geometric, ball).apply(geometric) - ball))
    exported, nominal = calibrated.geometry, calibrated.model.nominal
    for name in dict.fromkeys(p.joint for p in calibrated.parameters if p.joint in uncarried):
        without = np.where([p.joint == name for p in calibrated.parameters], nominal, exported)
        on_ball = name == robot.ball_joint.name
        place = f"the ball's place on {robot.ball_joint.parent}" if on_ball else ""
        loss = _loss(
            place or f"the origin of {name}", calibrated.model.points(without, q) - geometric
        )
        losses += [loss] if loss.largest > 0 else []
    return tuple(losses)


def _loss(what: str, differences: np.ndarray) -> Loss:
    distances = np.linalg.norm(differences, axis=1)
    return Loss(what, float(distances.mean()), float(distances.max()))

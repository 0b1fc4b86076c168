"""The corrections that a format cannot carry, each with its cost at the ball."""

from collections.abc import Collection

import numpy as np

from ...solver.data import kabsch
from .request import Loss, Request


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

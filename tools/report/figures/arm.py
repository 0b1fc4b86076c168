"""The arm in its recorded configurations, nominal and calibrated, for the 3D view."""

from functools import lru_cache

import casadi as ca
import numpy as np

from ....solver.assessment import Predictions, nice_above, norms
from ....solver.data import as_point
from ....solver.robot import Joint, Robot, RowFunction, link_frames
from .meshes import link_meshes
from .types import ArmDrawing, Displacement

CONFIGURATIONS = 400
"""Configurations drawn at most: of more, every second, third, ..."""
SHOWN_SHIFT = 0.05
"""The view first enlarges the difference of the two models to this share of the arm's reach."""


def arm_drawing(predictions: Predictions) -> ArmDrawing:
    """Return the skeletons of both models, and meshes where there are any."""
    robot, calibration = predictions.robot, predictions.calibration
    placements = predictions.placements
    measured = [each.measured for each in placements]
    owners = np.repeat(np.arange(len(placements)), [len(each.samples) for each in placements])
    q = np.concatenate([m.positions for m in measured])
    true = np.concatenate([calibration.true_positions(m.positions, m.efforts) for m in measured])
    apart = np.concatenate(
        [norms(each.points.nominal - each.points.calibrated) for each in placements]
    )
    rows = np.arange(0, len(q), -(-len(q) // CONFIGURATIONS))
    nominal = _frames(robot, robot.origins, q[rows])
    calibrated = _frames(robot, calibration.model.origins(calibration.values), true[rows])
    places = calibrated[..., 3]
    reach = float(np.abs(places).max())
    meshes = link_meshes(predictions.document.model, robot)
    shown = np.round(calibrated, 4).reshape(len(rows), -1, 12).tolist()
    return ArmDrawing(
        joints=tuple(joint.name for joint in robot.joints),
        placements=owners[rows].tolist(),
        nominal=np.round(nominal[..., 3], 5).tolist(),
        calibrated=np.round(places, 5).tolist(),
        low=as_point(places.min(axis=(0, 1)).round(4)),
        high=as_point(places.max(axis=(0, 1)).round(4)),
        reach=reach,
        displacement=Displacement(mean=float(apart.mean()), max=float(apart.max())),
        exaggeration=_exaggeration(float(apart.mean()), reach),
        meshes=meshes,
        frames=shown if meshes else None,
    )


def _exaggeration(displacement: float, reach: float) -> float:
    """Return a round factor that makes the models' difference visible."""
    if displacement < 1e-7:
        return 1.0
    return max(1.0, nice_above(SHOWN_SHIFT * reach / displacement / 2))


def _frames(robot: Robot, origins: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the frames of base and child links, [R | p], shape (N, joints + 1, 3, 4)."""
    numbers = _frames_function(robot.joints)(positions, origins.ravel())[0]
    links = numbers.reshape(len(positions), len(robot.joints), 3, 4)
    return np.insert(links, 0, np.eye(3, 4), axis=1)


@lru_cache(maxsize=16)
def _frames_function(joints: tuple[Joint, ...]) -> RowFunction:
    """Return the child links' frames as a function of joint positions and origins."""
    origins, q = ca.SX.sym("o", 6 * len(joints)), ca.SX.sym("q", sum(j.actuated for j in joints))
    frames = [ca.horzcat(ca.SX(R), ca.SX(p)) for R, p in link_frames(joints, origins, q)]
    return RowFunction("frames", [origins, q], [ca.vertcat(*frames)])

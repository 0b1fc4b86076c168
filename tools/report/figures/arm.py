"""The arm in its recorded configurations, nominal and calibrated, for the 3D view."""

from functools import lru_cache

import casadi as ca
import numpy as np

from ....solver.assessment import Predictions, nice_above, norms
from ....solver.data import Measurement, as_point
from ....solver.results import CalibratedRobot
from ....solver.robot import Joint, Robot, RowFunction, link_frames
from .meshes import link_meshes
from .types import ArmDrawing, Displacement

CONFIGURATIONS = 400
"""Configurations drawn at most."""
SHOWN_SHIFT = 0.05
"""The view first enlarges the difference of the two models to this share of the arm's reach."""


def arm_drawing(predictions: Predictions) -> ArmDrawing:
    """Return the skeletons of both models, and meshes where there are any.

    Where there are more than :data:`CONFIGURATIONS`, only every second, third, ... is drawn.
    """
    robot, calibration = predictions.robot, predictions.calibration
    placements = predictions.placements
    owners = np.repeat(np.arange(len(placements)), [len(each.samples) for each in placements])
    q = np.concatenate([each.measured.positions for each in placements])
    corrected = np.concatenate(
        [_corrected_positions(calibration, each.measured) for each in placements]
    )
    apart = np.concatenate(
        [norms(each.points.nominal - each.points.calibrated) for each in placements]
    )
    rows = np.arange(0, len(q), -(-len(q) // CONFIGURATIONS))
    nominal = _frames(robot, robot.origins, q[rows])
    calibrated = _frames(robot, calibration.model.origins(calibration.values), corrected[rows])
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


def _corrected_positions(calibration: CalibratedRobot, measured: Measurement) -> np.ndarray:
    """Return the joint positions that the calibrated geometry is applied to."""
    if not calibration.deflection.extensions:
        return measured.positions
    torques = calibration.load.torques(calibration.robot, measured)
    true = calibration.deflection.true_positions(measured.positions, torques)
    return true[:, : measured.positions.shape[1]]  # a tilt is too small to be seen


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

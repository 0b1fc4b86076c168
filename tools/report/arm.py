"""The arm in its recorded configurations, nominal and calibrated, for the 3D view."""

# CasADi has no types.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false, reportMissingTypeStubs=false

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...solver.robot.kinematics import link_frames
from ...solver.robot.urdf import Robot
from .evidence import Evidence, Seen
from .meshes import link_meshes
from .svg import nice_above

__all__ = ["arm_figures", "frames"]

Vector = NDArray[np.float64]
CONFIGURATIONS = 400
"""Configurations drawn at most."""
SHOWN_SHIFT = 0.05
"""By default the difference of the models is drawn so large that it is this share of the arm."""


def arm_figures(evidence: Evidence) -> dict[str, Any]:
    """Return the skeletons of both models, where the sockets are, and meshes where there are any.

    Returns:
        ``placements``: of each configuration drawn, an index. ``nominal``, ``calibrated``: the
        joints' places, shape (configurations, joints + 1, 3) [m], the base first and the ball
        last. ``low`` and ``high``: the corners of what they fill, and ``reach`` the largest
        coordinate [m]. ``displacement``: mean and maximum distance of the models' balls [m].
        ``exaggeration``: by how much the view enlarges the models' difference at first.
        ``meshes`` of the links, and with them the calibrated ``frames``, shape
        (configurations, joints + 1, 12), three rows of rotation and place each.
    """
    robot = evidence.robot
    nominal, calibrated = robot.origins, _calibrated_origins(evidence)
    owners = np.concatenate([np.full(len(s.samples), i) for i, s in enumerate(evidence.placements)])
    q = np.concatenate([_true_positions(evidence, seen) for seen in evidence.placements])
    apart = np.concatenate(
        [
            np.linalg.norm(s.points["nominal"] - s.points["calibrated"], axis=1)
            for s in evidence.placements
        ]
    )
    rows = np.arange(0, len(q), -(-len(q) // CONFIGURATIONS))
    read = np.concatenate([seen.measured.positions for seen in evidence.placements])
    both = [frames(robot, nominal, read[rows]), frames(robot, calibrated, q[rows])]
    reach = float(np.abs(both[1][:, :, :3, 3]).max())
    meshes = link_meshes(evidence.document["model"], robot)
    figures: dict[str, Any] = {
        "joints": [joint.name for joint in robot.joints],
        "placements": owners[rows].tolist(),
        "nominal": np.round(both[0][:, :, :3, 3], 5).tolist(),
        "calibrated": np.round(both[1][:, :, :3, 3], 5).tolist(),
        "low": both[1][:, :, :3, 3].min(axis=(0, 1)).round(4).tolist(),
        "high": both[1][:, :, :3, 3].max(axis=(0, 1)).round(4).tolist(),
        "reach": reach,
        "displacement": {"mean": float(apart.mean()), "max": float(apart.max())},
        "exaggeration": _exaggeration(float(apart.mean()), reach),
        "meshes": meshes,
    }
    if meshes:
        figures["frames"] = np.round(both[1][:, :, :3, :], 4).reshape(len(rows), -1, 12).tolist()
    return figures


def _true_positions(evidence: Evidence, seen: Seen) -> Vector:
    """Return the joint positions that the calibrated geometry is applied to."""
    calibration, measured = evidence.calibration, seen.measured
    if not calibration.deflection.extensions:
        return measured.positions
    torques = calibration.load.torques(evidence.robot, measured)
    return calibration.deflection.true_positions(measured.positions, torques)


def _calibrated_origins(evidence: Evidence) -> Vector:
    return evidence.calibration.model.origins(evidence.calibration.values)


def _exaggeration(displacement: float, reach: float) -> float:
    """Return a round factor that makes the models' difference visible."""
    if displacement < 1e-7:
        return 1.0
    return max(1.0, nice_above(SHOWN_SHIFT * reach / displacement / 2))


def frames(robot: Robot, origins: Vector, positions: Vector) -> Vector:
    """Return the frames of the base and of each joint's child link, shape (N, joints + 1, 4, 4).

    Args:
        robot: The robot.
        origins: Of its joints, shape (joints, 6).
        positions: Joint positions, shape (N, m).
    """
    q = ca.SX.sym("q", len(robot.actuated))
    parts = [
        ca.vec(ca.vertcat(ca.SX(R).T, ca.SX(p).T))
        for R, p in link_frames(robot.joints, ca.DM(origins.ravel()), q)
    ]
    function = ca.Function("frames", [q], [ca.densify(ca.horzcat(*parts))])
    N = len(positions)
    numbers = function.map(N)(positions.T).full().T.reshape(N, len(robot.joints), 3, 4)
    T = np.tile(np.eye(4), (N, len(robot.joints) + 1, 1, 1))
    T[:, 1:, :3, :] = numbers
    return T

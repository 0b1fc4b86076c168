"""Frames and arms of a calibration as figures: where each stands, and how well that is known."""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from ..bayes.inference import JointPosterior
from ..bayes.results import between
from ..data import IDENTITY, WORLD, Pose, as_point
from ..results import ArmsDocument, FramePose, GivenArm, VisitedSocket
from ..robot import link_frames
from .calibration import Calibration


def frame_poses(world: JointPosterior) -> tuple[FramePose, ...]:
    """Return the frames in which sockets or points were measured, in the first robot's base."""
    poses = [
        _frame_pose(world, k, name, pose, world.frame_covariance(name))
        for k, (name, pose) in enumerate(world.frames.items())
        if k not in world.scene.bases
    ]
    if any(one.frame == WORLD for one in world.scene.arms[0].located):
        poses.append(_frame_pose(world, WORLD, "base", IDENTITY, np.zeros((6, 6))))
    return tuple(poses)


def _frame_pose(
    world: JointPosterior, k: int, name: str, pose: Pose, covariance: np.ndarray
) -> FramePose:
    """Return a frame by its index, its name, its pose and the covariance of that."""
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    located = [one for one in world.scene.arms[0].located if one.frame == k]
    error = None
    if located:
        places = pose.apply(np.array([one.coordinates for one in located]))
        # the first robot's base is the world
        off = world.arms[0].centres[[one.socket for one in located]] - places
        error = float(np.sum(off**2, axis=1).mean()) ** 0.5
    return FramePose(
        name=name,
        xyz=pose.origin.xyz,
        rpy=pose.origin.rpy,
        xyz_deviation=as_point(deviation[3:]),
        turn_deviation=as_point(deviation[:3]),
        sockets=len(located),
        points=sum(int((arm.measured_in == k).sum()) for arm in world.scene.arms if k != WORLD),
        socket_error=error,
    )


def _visited_sockets(world: JointPosterior) -> tuple[VisitedSocket, ...]:
    """Return all sockets in the first robot's base, and which robots were there."""
    robots = list(zip(world.scene.names, world.scene.arms, strict=True))
    places = zip(world.scene.arms[0].labels, world.arms[0].centres, strict=True)
    return tuple(
        VisitedSocket(
            name=f"{placement}:{socket}",
            xyz=as_point(centre),
            robots=tuple(name for name, arm in robots if k in arm.sockets),
        )
        for k, ((placement, socket), centre) in enumerate(places)
    )


def _postures(world: JointPosterior, robot: int) -> list[list[list[float]]]:
    """Return how a robot stood at each base that it shares; see :attr:`GivenArm.postures`."""
    arm, data, base = world.arms[robot], world.scene.arms[robot], world.scene.bases[robot]
    pose = IDENTITY if base == WORLD else list(world.frames.values())[base]
    others = [o.sockets for i, o in enumerate(world.scene.arms) if i != robot]
    shared = np.isin(data.sockets, np.concatenate(others)) & (data.sockets >= 0)
    shared_sockets: list[int] = np.unique(data.sockets[shared]).tolist()
    first = {data.labels[k][0]: k for k in reversed(shared_sockets)}
    origins = ca.DM(arm.model.ball.origins(arm.values).ravel())
    places: list[list[list[float]]] = []
    for socket in first.values():
        row = int(np.argmax(data.sockets == socket))
        frames = link_frames(arm.model.robot.joints, origins, ca.DM(data.positions[row]))
        joints = np.array([np.zeros(3), *(np.array(ca.DM(p)).ravel() for _, p in frames)])
        places.append(pose.apply(joints).round(5).tolist())
    return places


def common_document(
    calibrations: Mapping[str, Calibration], posterior: JointPosterior
) -> ArmsDocument:
    """Return everything that robots have in common."""
    first, *others = calibrations
    return ArmsDocument(
        robots=tuple(calibrations),
        between={f"{first}_to_{n}": between(posterior, i) for i, n in enumerate(others, 1)},
        frames=frame_poses(posterior),
        arms=tuple(
            GivenArm(
                name=name,
                robot=one.document.robot,
                options=dict(one.robot.loaded_with),
                train=tuple(row.folder for row in one.document.data if row.role == "train"),
                test=tuple(row.folder for row in one.document.data if row.role == "test"),
                postures=_postures(posterior, i),
            )
            for i, (name, one) in enumerate(calibrations.items())
        ),
        sockets=_visited_sockets(posterior),
    )

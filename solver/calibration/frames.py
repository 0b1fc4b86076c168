"""Frames and arms of a calibration as figures: where each stands, and how well that is known."""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from ..bayes.inference import JointPosterior
from ..bayes.results import RelativeBasePose, between
from ..data import IDENTITY, WORLD, Pose, as_point
from ..results import ArmsDocument, BaseToBase, FramePose, GivenArm, VisitedSocket
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
    measured = [arm.instrument for arm in world.scene.arms if arm.instrument is not None]
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
        points=sum(int((one.frames == k).sum()) for one in measured if k != WORLD),
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
    pairs = [between(posterior, i) for i in range(1, len(calibrations))]
    return ArmsDocument(
        robots=tuple(calibrations),
        between={f"{one.names[0]}_to_{one.names[1]}": _base_to_base(one) for one in pairs},
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


def _base_to_base(one: RelativeBasePose) -> BaseToBase:
    """Return numbers and words; the numbers only where they mean something."""
    known, origin = one.unseen is None, one.pose.origin
    deviation = np.sqrt(np.diag(one.covariance).clip(min=0))
    return BaseToBase(
        xyz=origin.xyz if known else None,
        rpy=origin.rpy if known else None,
        xyz_deviation=as_point(deviation[3:]) if known else None,
        turn_deviation=as_point(deviation[:3]) if known else None,
        tool_deviation=one.tools if known else None,
        shared_sockets=one.shared,
        text=_words(one, deviation) if one.unseen is None else _turned(one, one.unseen),
    )


def _words(one: RelativeBasePose, deviation: np.ndarray) -> str:
    first, second = one.names
    place = " ".join(f"{1e3 * value:+.2f}" for value in one.pose.origin.xyz)
    turned = " ".join(f"{np.degrees(value):+.3f}" for value in one.pose.origin.rpy)
    frames = (
        f"{second}'s base stands at {place} mm (+- {1e3 * deviation[3:].max():.2f}), turned "
        f"{turned} deg (+- {np.degrees(deviation[:3].max()):.2f}) in {first}'s: no better, since "
        "each base frame hangs on its own joint 1 zero, which no ball shows"
    )
    if one.tools is None:
        return f"{frames}. No place was found that both tools reach."
    return (
        f"Tool to tool, where {second}'s tool stands seen from {first}'s in the shared region, is "
        f"known to {1e3 * one.tools:.2f} mm (1 sigma), by both calibrated models together. "
        f"{frames[0].upper()}{frames[1:]}."
    )


def _turned(one: RelativeBasePose, axis: np.ndarray) -> str:
    """Return what is missing where a turn of one robot against the other is left."""
    first, second = one.names
    along = " ".join(f"{value:+.2f}" for value in axis)
    count = {0: "no socket", 1: "one socket", 2: "two sockets"}.get(
        one.shared, f"{one.shared} sockets on one line"
    )
    left = "about their line" if one.shared > 1 else "about it"
    return (
        f"{second} stands nowhere yet seen from {first}: {count} shared leave it free to turn "
        f"{left} (along {along} in {first}'s base). Let both record one more placement, off that "
        "line: two placements cure it, three are better."
    )

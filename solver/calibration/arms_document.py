"""What robots have in common, as ``arms.json`` holds it: where their bases stand, and for what."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

import numpy as np
from msgspec.structs import replace

from .. import results
from ..assessment import mm
from ..bases import TiedRobots, base_to_base
from ..identification.data import IDENTITY, Measurement, Pose, as_point
from ..identification.robot import Origin, link_poses
from .calibration import Calibration
from .shared_places import poses_for_urdf

URDF_WORDS = (
    "By arms.urdf, tool to tool is off by {} more at the shared places; {}'s base stands there "
    "where both calibrated.urdf fit best."
)


def known_poses(document: results.ArmsDocument) -> dict[str, Pose]:
    """Return the poses of bases in the first one's; those that are not known are missing."""
    first, *names = document.robots
    poses = {first: IDENTITY}
    for name in names:
        relative = document.between[f"{first}_to_{name}"]
        if relative.xyz and relative.rpy:
            poses[name] = Pose.of(Origin(relative.xyz, relative.rpy))
    return poses


def with_urdf_poses(
    document: results.ArmsDocument,
    robots: Mapping[str, results.CalibratedRobot],
    data: Mapping[str, Sequence[Measurement]],
) -> results.ArmsDocument:
    """Return what robots have in common, with the poses of bases for ``arms.urdf``."""
    if all(robot.exported is None for robot in robots.values()):
        return document
    first, *fitted = poses_for_urdf(robots, known_poses(document), data).items()
    between = dict(document.between)
    for name, second in fitted:
        origin = (first[1].pose.inverse() @ second.pose).origin
        error = float(np.hypot(first[1].error, second.error))
        key = f"{first[0]}_to_{name}"
        urdf = results.UrdfPose(xyz=origin.xyz, rpy=origin.rpy, tool_error=error)
        text = f"{between[key].text} {URDF_WORDS.format(mm(error), name)}"
        between[key] = replace(between[key], urdf=urdf, text=text)
    return replace(document, between=between)


def common_document(
    calibrations: Mapping[str, Calibration], world: TiedRobots
) -> results.ArmsDocument:
    """Return everything that robots have in common."""
    first, *names = calibrations
    relative = {
        f"{first}_to_{n}": base_to_base(world, i) for i, n in enumerate(names, 1)
    }
    standing = [0, *(i for i, pose in enumerate(relative.values(), 1) if pose.xyz)]
    arms: list[results.GivenArm] = []
    for i, (name, calibration) in enumerate(calibrations.items()):
        data = calibration.document.data
        arm = results.GivenArm(
            name=name,
            robot=calibration.document.robot,
            options=dict(calibration.robot.loaded_with),
            train=tuple(row.folder for row in data if row.role == "train"),
            test=tuple(row.folder for row in data if row.role == "test"),
            postures=_postures(world, i) if i in standing else [],
        )
        arms.append(arm)
    return results.ArmsDocument(
        robots=tuple(calibrations),
        between=relative,
        frames=world.frames,
        arms=tuple(arms),
        sockets=tuple(_visited_sockets(world, standing)),
    )


def _visited_sockets(
    world: TiedRobots, standing: Sequence[int]
) -> Iterator[results.VisitedSocket]:
    """Yield the sockets of robots whose bases are known, in the first one's base."""
    known = {world.robots[i].name for i in standing}
    for k, (placement, socket) in enumerate(world.places.labels):
        names = tuple(robot.name for robot in world.robots if k in robot.sockets)
        if not known.isdisjoint(names):
            xyz = as_point(world.centres[k])
            name = f"{placement}:{socket}"
            yield results.VisitedSocket(name=name, xyz=xyz, robots=names)


def _postures(world: TiedRobots, robot: int) -> list[list[list[float]]]:
    """Return how a robot stood at each base that it shares; see :attr:`GivenArm.postures`."""
    arm = world.arms[robot]
    visitor = world.robots[robot]
    others = chain(*(other.sockets for other in world.robots if other is not visitor))
    shared = np.flatnonzero(np.isin(visitor.sockets, list(others)))
    rows = np.flatnonzero(np.isin(arm.data.sockets, shared))
    _, first = np.unique(arm.data.recorded_at[rows], return_index=True)
    q = arm.data.q[rows[first]]
    origins = arm.model.ball.origins(arm.values)
    places = link_poses(arm.model.robot.joints, q, origins)[..., 3]
    return world.poses[visitor.frame].apply(places).round(5).tolist()

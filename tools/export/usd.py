"""A layer over the user's own USD model, in which the arm's joints are the calibrated ones.

With all joints at zero let W_i be joint i's frame, and L_i and K_i the pose of its URDF link by the
nominal and the calibrated arm, aligned with the model. The frame is fixed in the link, so the new
one is W'_i = K_i L_i^-1 W_i. Bodies keep their shapes, and stand as they did, angle for angle.
"""

from collections.abc import Sequence
from typing import cast

import numpy as np

from .mjcf import align, links_at_zero, sites_on
from .request import Exported, Request, after_last_exported, exported
from .usd_stage import UsdJoint, UsdStage


def write(request: Request) -> Exported:
    """Return the layer; of the model that ``--like`` names it holds nothing."""
    stage = UsdStage(request)
    joints = stage.arm(request)
    at_zero, ends = _at_zero(joints)
    rotations = at_zero[:, :3, :3]
    turned = zip(rotations, joints, strict=True)
    axes = np.array([R @ joint.axis for R, joint in turned])
    robot = request.robot
    names = [joint.prim.GetName() for joint in joints]
    nominal = links_at_zero(robot.origins, request)
    places = at_zero[:, :3, 3]
    base, aligned, lines = align(request, names, places, axes, nominal)
    calibrated = links_at_zero(request.origins, request)
    motions = base @ calibrated @ _inverse(aligned)
    first = joints[0].bodies[0]
    bodies = [first, *(joint.bodies[1] for joint in joints)]
    stands = list(map(stage.world_pose, bodies))
    moved = {first: np.eye(4)}
    end, stand = np.eye(4), stands[0]
    for i, joint in enumerate(joints):
        moved_frame = motions[i] @ at_zero[i]
        frame = stage.set_frame(joint, _inverse(end) @ moved_frame)
        back = _inverse(joint.frames[1])
        end = end @ frame @ back
        # the angle at which the joint stands in the model, and what else its bodies are apart
        here = stands[i] @ joint.frames[0]
        angle = _inverse(here) @ stands[i + 1] @ joint.frames[1]
        stand = stand @ frame @ angle @ back
        moved[joint.bodies[1]] = stand @ _inverse(stands[i + 1])
    _carry(stage, moved)
    to_last = _inverse(motions[-1] @ ends[-1])
    for name, T in sites_on(request, to_last @ base).items():
        stage.place(f"{bodies[-1]}/{name}", stand @ T)
    lines += [
        f"Open {request.file.name}: a layer over {request.like}, which holds the changes alone.",
        "USD keeps joints in single precision: within 0.0001 mm of the calibration.",
    ]
    about = "; ".join(request.identity.lines())
    text = stage.text(request.file.parent, about)
    held = after_last_exported(request, robot.joint_names)[:-1]
    return exported(request, text, lines, held)


def _inverse(T: np.ndarray) -> np.ndarray:
    return cast("np.ndarray", np.linalg.inv(T))


def _at_zero(joints: Sequence[UsdJoint]) -> tuple[np.ndarray, np.ndarray]:
    """Return where frames and second bodies of joints stand at zero in the base, (N, 4, 4)."""
    frames: list[np.ndarray] = []
    ends: list[np.ndarray] = []
    end = np.eye(4)
    for joint in joints:
        frames.append(end @ joint.frames[0])
        end = frames[-1] @ _inverse(joint.frames[1])
        ends.append(end)
    return np.array(frames), np.array(ends)


def _carry(stage: UsdStage, moved: dict[str, np.ndarray]) -> None:
    """Move bodies in the world, (4, 4) by their paths, with all that hang on them by joints."""
    for _ in stage.joints:
        for joint in stage.joints:
            first, second = joint.bodies
            if first in moved and second:
                moved.setdefault(second, moved[first])
    places = {
        path: T @ stage.world_pose(path)
        for path, T in moved.items()
        if np.any(np.eye(4) != T)
    }
    for path in sorted(places):  # a body before those inside it
        stage.place(path, places[path])

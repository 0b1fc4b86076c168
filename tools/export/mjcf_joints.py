"""Joints of a MuJoCo model that are the arm's."""

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from ...solver.calibration import joints_named
from .request import ExportError, Request


class MjcfJoints(NamedTuple):
    """Joints of the MuJoCo model at zero, in the frame of the body that carries the first."""

    names: list[str]
    bodies: list[str]
    axes: np.ndarray
    """Shape (N, 3)."""
    poses: np.ndarray
    parents: np.ndarray
    """Poses of the bodies and their parents, each welded to the body before, shape (N, 4, 4)."""


def read_joints(request: Request) -> MjcfJoints:
    """Return the joints of ``--like`` that are the arm's, in the arm's order.

    Raises:
        ExportError: MuJoCo is not installed or cannot read the model, or its joints are others.
    """
    model, data = _at_zero(request)
    # Types 2 and 3 are slide and hinge.
    single = [j for j in range(model.njnt) if model.jnt_type[j] in (2, 3)]
    matches = match_joints([model.joint(j).name for j in single], request)
    indices = [single[i] for i in matches]
    names = [model.joint(j).name for j in indices]
    bodies: list[int] = model.jnt_bodyid[indices].tolist()
    parents: list[int] = model.body_parentid[bodies].tolist()
    before = [parents[0], *bodies]
    rows = zip(
        indices,
        bodies,
        parents,
        before,
        strict=False,
    )
    for j, body, parent, previous in rows:
        _check_joint(model, request, j)
        if previous not in (parent, model.body_weldid[parent]):
            raise ExportError(
                f"{request.like}: body {model.body(body).name!r} does not hang on the joint "
                "that is before it in the URDF's chain; put the bodies in that order"
            )
    poses = cast("Any", np.tile(np.eye(4), (model.nbody, 1, 1)))
    poses[:, :3, :3] = data.xmat.reshape(-1, 3, 3)
    poses[:, :3, 3] = data.xpos
    to_base = cast("Any", np.linalg.inv(poses[parents[0]]))
    frames: np.ndarray = to_base @ poses
    directions: np.ndarray = data.xaxis[indices]
    axes: np.ndarray = np.matmul(frames[0, :3, :3], directions[:, :, None])[:, :, 0]
    names_of_bodies = [model.body(body).name for body in bodies]
    return MjcfJoints(
        names,
        names_of_bodies,
        axes,
        frames[bodies],
        frames[parents],
    )


def _at_zero(request: Request) -> tuple[Any, Any]:
    """Return the model that ``--like`` names, and its data with all joints at zero."""
    try:
        import mujoco
    except ImportError:
        raise ExportError(
            "mujoco is not installed; install the extra: pip install 'mukca[simulation]'"
        ) from None
    # MuJoCo would warn, and leave a log.
    if not request.like or not request.like.is_file():
        raise ExportError(f"--like {request.like}: no such file")
    try:
        model = mujoco.MjModel.from_xml_path(str(request.like))
    except ValueError as error:
        hint = "; name the model that includes it" * ("mujocoinclude" in str(error))
        raise ExportError(
            f"--like {request.like}: MuJoCo cannot read it: {error}{hint}"
        ) from None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def _check_joint(model: Any, request: Request, index: int) -> None:
    """Refuse a joint that is not alone at the origin of its body, or whose zero is elsewhere."""
    name = model.joint(index).name
    alone = model.body_jntnum[model.jnt_bodyid[index]] == 1
    if not alone or model.qpos0[model.jnt_qposadr[index]] != 0:
        raise ExportError(f"{request.like}: {name!r} shares its body, or has a `ref`")
    if np.any(model.jnt_pos[index]):
        raise ExportError(
            f"{request.like}: {name!r} has a `pos`; set it to 0, and move its body there"
        )


def match_joints(names: Sequence[str], request: Request) -> list[int]:
    """Return which of a model's joints are the arm's, by name, or by order if no name is.

    Raises:
        ExportError: A joint is absent, or there are several.
    """
    model_joints = request.robot.joint_names
    single = range(len(names))
    joints_given = request.options.get("joints")
    if joints_given is not None:
        model_joints = joints_named(joints_given, model_joints)
    candidates = [[j for j in single if names[j] == joint] for joint in model_joints]
    if joints_given is None and not all(candidates):
        candidates = [
            [j for j in single if _but_for_a_prefix(names[j], joint)]
            for joint in model_joints
        ]
        if not any(candidates) and len(single) == len(model_joints):
            return [*single]
    if all(len(matches) == 1 for matches in candidates):
        return [matches[0] for matches in candidates]
    pairs = zip(model_joints, candidates, strict=True)
    absent = [joint for joint, matches in pairs if not matches]
    if not absent:
        several = [names[j] for j in max(candidates, key=len)]
        raise ExportError(
            f"{request.like}: has several arms, with {', '.join(several)}; say which, as in "
            f"--joints '{several[0].replace(model_joints[0], '*')}'"
        )
    raise ExportError(
        f"{request.like}: its joints do not match; of {request.robot.name} it lacks "
        f"{', '.join(absent)}; its own: {', '.join(names) or 'none'}; --joints names them"
    )


def _but_for_a_prefix(name: str, joint: str) -> bool:
    """Return whether a name is a joint's but for a prefix of either, as panda_ or left/."""
    return name.endswith(joint) or (name != "" and joint.endswith(f"_{name}"))

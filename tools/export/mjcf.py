"""The user's own MuJoCo model, with the places of the arm's bodies replaced and all else kept.

Frames of the bodies may stand elsewhere on the links than the URDF's: only the joints' axes are
the same. With B_i the pose of joint i's body and L_i that of its URDF link, both nominal and at
zero, the constant C_i = B_i^-1 L_i carries one into the other. So the body's new place on the one
before is

    C_(i-1) K_i C_i^-1

with K_i the calibrated place of the URDF's link on the one before, at zero.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import casadi as ca
import numpy as np

from ...solver.robot.kinematics import rotation
from .export import Exported, ExportError, Request, losses_without
from .folding import behind
from .mjcf_text import add_text, place_bodies
from .transforms import rigid

__all__ = ["export"]

SAME_AXIS = 1e-4
"""How far the axes of both models may be apart [m]."""
SAME_DIRECTION = 1e-3
"""How much they may be turned against each other [rad]."""


@dataclass(frozen=True)
class MjcfJoint:
    """A joint of the MuJoCo model that is one of the arm's, with all at zero."""

    name: str
    body: str
    axis: np.ndarray
    """In the body's frame."""
    place: np.ndarray
    """The body's pose on the body of the joint before, shape (4, 4)."""
    welded: np.ndarray
    """The pose of its parent body on the body of the joint before; they are welded."""


def export(request: Request) -> Exported:
    """Return the model that ``--like`` names, with the calibrated places of its bodies."""
    if request.like is None:
        raise ExportError("--to mjcf needs --like FILE, your own MuJoCo model, which it corrects")
    joints = _joints(request)
    robot = request.calibration.robot
    nominal = _links([joint.origin.xyz + joint.origin.rpy for joint in robot.joints], request)
    calibrated = _links(request.origins, request)
    carried = _carriers(request, joints, nominal)
    places: dict[str, np.ndarray] = {}
    for i, joint in enumerate(joints):
        place = carried[i] @ calibrated[i] @ np.linalg.inv(carried[i + 1])
        places[joint.body] = np.linalg.inv(joint.welded) @ place
    text = place_bodies(request.like.read_bytes(), places, str(request.like))
    identity = "; ".join(request.identity.lines())
    text = add_text(text, "mukca", identity)
    lines = ["Keyframes stay right as joint angles, not as poses of a tool."]
    if request.file.resolve().parent != request.like.resolve().parent:
        lines.append(f"Put it beside {request.like}: what it includes is looked for there.")
    losses = losses_without(request, behind(request, robot.joint_names))
    return Exported({request.file.name: text}, losses, tuple(lines))


def _links(origins: Any, request: Request) -> list[np.ndarray]:
    """Return the pose of each moving joint's child link on that of the one before, at zero."""
    links: list[np.ndarray] = []
    rest = np.eye(4)
    for joint, origin in zip(request.calibration.robot.joints, origins, strict=True):
        rest = rest @ rigid(origin)
        if joint.actuated:
            links.append(rest)
            rest = np.eye(4)
    return links


# -- the MuJoCo model ------------------------------------------------------------------------------


def _joints(request: Request) -> list[MjcfJoint]:
    """Return the model's joints that are the arm's, in the arm's order.

    Raises:
        ExportError: The model cannot be read, or is not of this arm.
    """
    try:
        import mujoco
    except ImportError:
        raise ExportError(
            "mujoco is not installed; install the extra: pip install 'mukca[simulation]'"
        ) from None
    try:
        model = mujoco.MjModel.from_xml_path(str(request.like))
    except ValueError as error:
        raise ExportError(f"--like {request.like}: MuJoCo cannot read it: {error}") from None
    indices = _matched(model, request)
    bodies = [int(model.jnt_bodyid[j]) for j in indices]
    before = int(model.body_parentid[bodies[0]])
    joints: list[MjcfJoint] = []
    for j, body in zip(indices, bodies, strict=True):
        name = model.joint(j).name
        if model.body_jntnum[body] != 1 or model.qpos0[model.jnt_qposadr[j]] != 0:
            raise ExportError(f"{request.like}: {name!r} shares its body, or has a `ref`")
        if np.any(model.jnt_pos[j]):
            raise ExportError(f"{request.like}: {name!r} has a `pos`; put its body there instead")
        path = _path(model, before, body, request)
        places = [_local(model, b) for b in path]
        welded = reduce(np.matmul, places[:-1], np.eye(4))
        axis = np.array(model.jnt_axis[j])
        joints.append(MjcfJoint(name, model.body(body).name, axis, welded @ places[-1], welded))
        before = body
    return joints


def _matched(model: Any, request: Request) -> list[int]:
    """Return the model's joints by the arm's names, or by order where it names none of them."""
    wanted = request.calibration.robot.joint_names
    single = [j for j in range(model.njnt) if model.jnt_type[j] in (2, 3)]  # slide, hinge
    names = [model.joint(j).name for j in single]
    found = [
        [j for j, name in zip(single, names, strict=True) if name and _same(name, joint)]
        for joint in wanted
    ]
    if all(len(each) == 1 for each in found):
        return [each[0] for each in found]
    if not any(found) and len(single) == len(wanted):
        return single
    missing = [joint for joint, each in zip(wanted, found, strict=True) if len(each) != 1]
    raise ExportError(
        f"{request.like}: its joints do not match; of {request.calibration.robot.name} it lacks "
        f"{', '.join(missing)}, or has them twice; its own: {', '.join(names) or 'none'}"
    )


def _same(name: str, other: str) -> bool:
    """Tell whether two names are one but for what stands before them, as panda_ or left/."""
    return name.endswith(other) or other.endswith(f"_{name}") or name == other


def _path(model: Any, before: int, body: int, request: Request) -> list[int]:
    """Return the bodies after one body, down to another."""
    path = [body]
    while model.body_parentid[path[0]] != before:
        path.insert(0, int(model.body_parentid[path[0]]))
        if path[0] == 0 or model.body_jntnum[path[0]]:
            raise ExportError(
                f"{request.like}: body {model.body(body).name!r} does not hang where the joint "
                "before it is; the joints stand in another order"
            )
    return path


def _local(model: Any, body: int) -> np.ndarray:
    import mujoco

    R = np.empty(9)
    mujoco.mju_quat2Mat(R, model.body_quat[body])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R.reshape(3, 3), model.body_pos[body]
    return T


# -- one model laid on the other -------------------------------------------------------------------


def _carriers(
    request: Request, joints: list[MjcfJoint], nominal: list[np.ndarray]
) -> list[np.ndarray]:
    """Return C_0 of the base and C_i of each joint.

    Raises:
        ExportError: The axes of both models do not coincide.
    """
    actuated = request.calibration.robot.actuated
    bodies = list(_products([joint.place for joint in joints]))
    links = list(_products(nominal))
    axes = np.array([B[:3, :3] @ j.axis for B, j in zip(bodies, joints, strict=True)])
    others = np.array([L[:3, :3] @ j.axis for L, j in zip(links, actuated, strict=True)])
    turning = [joint.type != "prismatic" for joint in actuated]
    base = _laid(axes, others, bodies, links, turning)
    carriers = [base]
    for B, L, mine, theirs in zip(bodies, links, joints, actuated, strict=True):
        C = np.linalg.inv(B) @ base @ L
        turn = np.cross(C[:3, :3] @ theirs.axis, mine.axis)
        off = C[:3, 3] - mine.axis * (mine.axis @ C[:3, 3])
        if theirs.type == "prismatic":
            off = np.zeros(3)
        same = mine.axis @ C[:3, :3] @ theirs.axis > 0
        if not same or np.linalg.norm(turn) > SAME_DIRECTION or np.linalg.norm(off) > SAME_AXIS:
            angle = np.degrees(np.arctan2(np.linalg.norm(turn), 1 if same else -1))
            raise ExportError(
                f"{request.like}: the axis of {mine.name!r} is not that of {theirs.name!r}: "
                f"{1e3 * np.linalg.norm(off):.2f} mm and {angle:.2f} degrees off; "
                "it is another arm's model, or counts its angles otherwise"
            )
        C[:3, :3] = _turned(turn) @ C[:3, :3]  # rounding in either model
        C[:3, 3] -= off
        carriers.append(C)
    return carriers


def _turned(turn: np.ndarray) -> np.ndarray:
    """Return the turn about a small vector, by its sine."""
    sine = float(np.linalg.norm(turn))
    if sine == 0:
        return np.eye(3)
    return rotation((turn / sine).tolist(), ca.DM(np.arcsin(sine))).full()


def _products(places: list[np.ndarray]) -> list[np.ndarray]:
    return [reduce(np.matmul, places[: i + 1]) for i in range(len(places))]


def _laid(
    axes: np.ndarray,
    others: np.ndarray,
    bodies: list[np.ndarray],
    links: list[np.ndarray],
    turning: list[bool],
) -> np.ndarray:
    """Return the pose of the URDF's base in the model's, which lays its axes on the model's."""
    U, _, V = np.linalg.svd(others.T @ axes)
    R = (U @ np.diag([1.0, 1.0, np.linalg.det(U @ V)]) @ V).T
    rows = [np.eye(3) - np.outer(a, a) for a, turns in zip(axes, turning, strict=True) if turns]
    gaps = [B[:3, 3] - R @ L[:3, 3] for B, L in zip(bodies, links, strict=True)]
    aims = [gap for gap, turns in zip(gaps, turning, strict=True) if turns]
    T = np.eye(4)
    T[:3, :3] = R
    if rows:
        across = np.concatenate([row @ aim for row, aim in zip(rows, aims, strict=True)])
        T[:3, 3] = np.linalg.lstsq(np.concatenate(rows), across, rcond=None)[0]
    return T

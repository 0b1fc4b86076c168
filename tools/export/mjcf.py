"""The user's own MuJoCo model, with the places of the arm's bodies replaced and all else kept.

Bodies may stand elsewhere on the links than the URDF's frames: only the joints' axes are the same.
With B_i the pose of joint i's body and L_i that of its URDF link, both nominal and at zero, the
constant C_i = B_i^-1 L_i carries one into the other. So the body's new place on the one before is
C_(i-1) K_i C_i^-1, with K_i the calibrated place of the URDF's link on the one before, at zero.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import casadi as ca
import numpy as np

from ...solver.calibration import joints_named
from ...solver.data import kabsch_rotation
from ...solver.robot import rotation
from .losses import losses_without
from .mjcf_text import add_text, place_bodies
from .origins import after_last_exported, rigid
from .request import Exported, ExportError, Request

SAME_AXIS = 2e-3
"""Largest distance between the axes of both models [m]; models in use differ by a millimetre."""
SAME_DIRECTION = 5e-3
"""Largest angle between them [rad]."""
ROUNDED = 1e-4
"""Axes nearer than this [m], and turned by less [rad], differ by their models' rounding."""
WEIGHT = 0.1
"""Weight of an axis relative to the one before it, where both models are aligned."""


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


def write(request: Request) -> Exported:
    """Return the model that ``--like`` names, with the calibrated places of its bodies."""
    if request.like is None:
        raise ExportError("--to mjcf needs --like FILE, your own MuJoCo model, which it corrects")
    joints = _joints(request)
    robot = request.calibration.robot
    nominal = _links([joint.origin.xyz + joint.origin.rpy for joint in robot.joints], request)
    calibrated = _links(request.origins, request)
    carried, lines = _carriers(request, joints, nominal)
    places: dict[str, np.ndarray] = {}
    for i, joint in enumerate(joints):
        place = carried[i] @ calibrated[i] @ np.linalg.inv(carried[i + 1])
        places[joint.body] = np.linalg.inv(joint.welded) @ place
    holder, text = place_bodies(request.like, places)
    main = holder == request.like
    text = add_text(text, "; ".join(request.identity.lines()), "mukca" if main else None)
    lines.append("Keyframes stay right as joint angles, not as poses of a tool.")
    if not main:
        lines.append(f"It is {holder}, corrected, which {request.like} includes.")
    if request.file.resolve().parent != holder.resolve().parent:
        lines.append(f"Put it beside {holder}: what it includes is looked for there.")
    losses = losses_without(request, after_last_exported(request, robot.joint_names))
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
    """Return the model's joints that are the arm's, in the arm's order."""
    try:
        import mujoco
    except ImportError:
        raise ExportError(
            "mujoco is not installed; install the extra: pip install 'mukca[simulation]'"
        ) from None
    if request.like is None or not request.like.is_file():  # MuJoCo would warn, and leave a log
        raise ExportError(f"--like {request.like}: no such file")
    try:
        model = mujoco.MjModel.from_xml_path(str(request.like))
    except ValueError as error:
        hint = "; name the model that includes it" if "mujocoinclude" in str(error) else ""
        raise ExportError(f"--like {request.like}: MuJoCo cannot read it: {error}{hint}") from None
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
    given = request.options.get("joints")
    if given is not None:
        wanted = joints_named(given, wanted)
    candidates = [[j for j, name in zip(single, names, strict=True) if name == w] for w in wanted]
    if given is None and not all(candidates):
        candidates = [
            [j for j, n in zip(single, names, strict=True) if _same(n, w)] for w in wanted
        ]
    if all(len(each) == 1 for each in candidates):
        return [each[0] for each in candidates]
    if not any(candidates) and given is None and len(single) == len(wanted):
        return single
    missing = [joint for joint, each in zip(wanted, candidates, strict=True) if not each]
    if not missing:
        several = [model.joint(j).name for j in max(candidates, key=len)]
        raise ExportError(
            f"{request.like}: has several arms, with {', '.join(several)}; say which, as in "
            f"--joints '{several[0].replace(wanted[0], '*')}'"
        )
    raise ExportError(
        f"{request.like}: its joints do not match; of {request.calibration.robot.name} it lacks "
        f"{', '.join(missing)}; its own: {', '.join(names) or 'none'}; --joints names them"
    )


def _same(name: str, other: str) -> bool:
    """Tell whether two names are one but for what stands before them, as panda_ or left/."""
    return name.endswith(other) or (name != "" and other.endswith(f"_{name}"))


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
) -> tuple[list[np.ndarray], list[str]]:
    """Return C_0 of the base and C_i of each joint, and how the nominal models differ."""
    actuated = request.calibration.robot.actuated
    bodies = list(_products([joint.place for joint in joints]))
    links = list(_products(nominal))
    axes = np.array([B[:3, :3] @ j.axis for B, j in zip(bodies, joints, strict=True)])
    others = np.array([L[:3, :3] @ j.axis for L, j in zip(links, actuated, strict=True)])
    turning = np.array([joint.type != "prismatic" for joint in actuated])
    base = _laid(axes, others, bodies, links, turning)
    turned = others @ base[:3, :3].T
    turns = np.cross(turned, axes)
    gaps = np.array([(base @ L - B)[:3, 3] for B, L in zip(bodies, links, strict=True)])
    offs = (gaps - axes * np.sum(axes * gaps, axis=1, keepdims=True)) * turning[:, None]
    distances = np.linalg.norm(offs, axis=1)
    angles = np.arctan2(np.linalg.norm(turns, axis=1), np.sum(axes * turned, axis=1))
    worst = int(np.argmax(distances / SAME_AXIS + angles / SAME_DIRECTION))
    said = (
        f"{request.like}: the axis of {joints[worst].name!r} is not that of "
        f"{actuated[worst].name!r}: {1e3 * distances[worst]:.2f} mm and "
        f"{np.degrees(angles[worst]):.2f} degrees off"
    )
    if distances.max() > SAME_AXIS or angles.max() > SAME_DIRECTION:
        raise ExportError(f"{said}; it is another arm's model, or counts its angles otherwise")
    carriers = [base]
    for B, L, turn, off in zip(bodies, links, turns, offs, strict=True):
        there = base @ L
        there[:3, :3] = _turned(turn) @ there[:3, :3]
        there[:3, 3] -= off
        carriers.append(np.linalg.inv(B) @ there)
    differ = max(distances.max(), angles.max()) > ROUNDED
    return carriers, [f"{said}; in the new file it is the calibrated arm's."] if differ else []


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
    turning: np.ndarray,
) -> np.ndarray:
    """Return the pose of the URDF's base in the model's, which lays its axes on the model's.

    Where the models differ, the axes next to the base count most: it stands still with them.
    """
    weights = WEIGHT ** np.arange(len(axes))
    R = kabsch_rotation(others, axes, weights)
    each = list(zip(weights, axes, bodies, links, strict=True))
    rows = [w * (np.eye(3) - np.outer(a, a)) for w, a, _, _ in each]
    gaps = [B[:3, 3] - R @ L[:3, 3] for _, _, B, L in each]
    T = np.eye(4)
    T[:3, :3] = R
    if turning.any():
        A = np.concatenate([row for row, turns in zip(rows, turning, strict=True) if turns])
        aims = [r @ g for r, g, turns in zip(rows, gaps, turning, strict=True) if turns]
        T[:3, 3] = np.linalg.lstsq(A, np.concatenate(aims), rcond=None)[0]
    return T

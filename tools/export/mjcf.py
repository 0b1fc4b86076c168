"""The user's own MuJoCo model, with the places of the arm's bodies replaced and all else kept.

With all joints at zero let B_i be the pose of joint i's body, and L_i and K_i those of its URDF
link by the nominal and the calibrated arm, aligned with the model. The link is fixed in the body,
B_i^-1 L_i is constant, and so the body's new pose is B'_i = K_i L_i^-1 B_i.
"""

import re
from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import accumulate
from pathlib import Path
from typing import Any, cast
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from ...errors import LARGEST_DOCUMENT, read_bytes
from ...solver.calibration import pose_of_numbers
from ...solver.identification.data import kabsch_rotation
from ...solver.identification.robot import end_of_tag, turn, with_attributes, with_edits
from .mjcf_joints import read_joints
from .request import (
    Exported,
    ExportError,
    Request,
    after_last_exported,
    exported,
    plain,
)

_TURNS = re.compile(rb"\s(euler|axisangle|xyaxes|zaxis)\s*=\s*(\"[^\"]*\"|'[^']*')")
SAME_AXIS = 2e-3
"""Largest distance between the axes of both models [m]; models in use differ by a millimetre."""
SAME_DIRECTION = 5e-3
"""Largest angle between them [rad]."""
ROUNDED = 1e-4
"""Axes nearer than this [m], and turned by less [rad], differ by their models' rounding."""
TINY = 1e-300
"""Keeps divisors from zero."""
WEIGHT = 0.1
"""Weight of an axis relative to the one before it, where both models are aligned."""


def write(request: Request) -> Exported:
    """Return the model that ``--like`` names, with the calibrated places of its bodies."""
    if not request.like:
        raise ExportError(
            "--to mjcf needs --like FILE, your own MuJoCo model, which it corrects"
        )
    joints = read_joints(request)
    robot = request.robot
    nominal = links_at_zero(robot.origins, request)
    base, aligned, lines = align(
        request, joints.names, joints.poses[:, :3, 3], joints.axes, nominal
    )
    # the motion of each body, and of the one before, from its place in the nominal model
    calibrated = links_at_zero(request.origins, request)
    motions = base @ calibrated @ np.linalg.inv(aligned)
    before = np.concatenate([np.eye(4)[None], motions[:-1]])
    poses = np.linalg.inv(before @ joints.parents) @ motions @ joints.poses
    last = motions[-1] @ joints.poses[-1]
    sites = sites_on(request, cast("np.ndarray", np.linalg.inv(last)) @ base)
    places = dict(zip(joints.bodies, poses, strict=True))
    holder, text = _with_places(request.like, places, joints.bodies[-1], sites)
    provenance = "; ".join(request.identity.lines())
    # of the main file, model.text("mukca") reads it
    added = f'<custom><text name="mukca" data={quoteattr(provenance)}/></custom>'
    lines.append("Keyframes stay right as joint angles, not as poses of a tool.")
    if holder != request.like:
        added = f"<!-- {provenance} -->"
        lines.append(f"It is {holder}, corrected, which {request.like} includes.")
    end = text.rindex(b"</mujoco")
    text = with_edits(text, [(end, end, f"  {added}\n".encode())])
    if request.file.resolve().parent != holder.resolve().parent:
        lines.append(f"Put it beside {holder}: what it includes is looked for there.")
    held = after_last_exported(request, robot.joint_names)[:-1]
    return exported(request, text, lines, held)


def sites_on(request: Request, to_body: np.ndarray) -> dict[str, np.ndarray]:
    """Return the poses of the ball and of tools that were found, (4, 4), by names of sites.

    ``to_body`` takes the base at zero to the last joint's body.
    """
    origins = pose_of_numbers(request.origins)
    to_flange = to_body @ reduce(np.matmul, origins[:-1])
    sites = {"mukca_ball": to_flange @ origins[-1]}
    for tool in request.calibration.document.tools:
        if tool.parent == request.flange:
            place = pose_of_numbers([*tool.xyz, *tool.rpy])
            sites[f"mukca_{plain(tool.name)}"] = to_flange @ place
    return sites


def links_at_zero(origins: Any, request: Request) -> np.ndarray:
    """Return the pose of each moving joint's child link in the base frame, at zero, (N, 4, 4)."""
    poses = np.array(list(accumulate(pose_of_numbers(origins), np.matmul)))
    return poses[[joint.actuated for joint in request.robot.joints]]


def align(
    request: Request,
    names: list[str],
    places: np.ndarray,
    axes: np.ndarray,
    nominal: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return poses of the URDF's base and links that fit the model's axes, and what differs.

    Places on the axes of the model's joints, and the axes, have shape (N, 3).
    """
    actuated = request.robot.actuated
    turning = np.array([joint.type != "prismatic" for joint in actuated])
    # a turning joint may be anywhere along its axis, a sliding one anywhere at all
    along = axes[:, :, None] * axes[:, None, :]
    across = turning[:, None, None] * (np.eye(3) - along)
    axes_in_links = [joint.axis for joint in actuated]
    urdf_axes = np.einsum("nij,nj->ni", nominal[:, :3, :3], axes_in_links)
    base = _base_of(
        nominal[:, :3, 3],
        urdf_axes,
        places,
        axes,
        across,
    )
    aligned = base @ nominal
    offsets = np.einsum("nij,nj->ni", across, places - aligned[:, :3, 3])
    turns, angles = _turns_between(urdf_axes @ base[:3, :3].T, axes)
    distances = np.linalg.norm(offsets, axis=1)
    worst = int(np.argmax(distances / SAME_AXIS + angles / SAME_DIRECTION))
    text = (
        f"{request.like}: the axis of {names[worst]!r} is not that of "
        f"{actuated[worst].name!r}: {1e3 * distances[worst]:.2f} mm and "
        f"{np.degrees(angles[worst]):.2f} degrees off"
    )
    if distances.max() > SAME_AXIS or angles.max() > SAME_DIRECTION:
        raise ExportError(
            f"{text}; it is another arm's model, or counts its angles otherwise"
        )
    rotations = np.array([turn(vector) for vector in turns])
    aligned[:, :3, :3] = rotations @ aligned[:, :3, :3]
    aligned[:, :3, 3] += offsets
    if max(distances.max(), angles.max()) <= ROUNDED:
        return base, aligned, []
    return base, aligned, [f"{text}; in the new file it is the calibrated arm's."]


def _base_of(
    urdf_places: np.ndarray,
    urdf_axes: np.ndarray,
    places: np.ndarray,
    axes: np.ndarray,
    across: np.ndarray,
) -> np.ndarray:
    """Return the pose (4, 4) of the URDF's base that lays its axes along the model's.

    Places and axes have shape (n, 3); ``across`` (n, 3, 3) takes what lies along an axis away.
    """
    weights = WEIGHT ** np.arange(len(axes))  # axes next to the base count most
    base = np.eye(4)
    R = kabsch_rotation(urdf_axes, axes, weights)
    rows = weights[:, None, None] * across
    aims = np.einsum("nij,nj->ni", rows, places - urdf_places @ R.T)
    base[:3, :3] = R
    base[:3, 3] = np.linalg.lstsq(rows.reshape(-1, 3), aims.ravel(), rcond=None)[0]
    return base


def _turns_between(
    axes: np.ndarray, others: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation vectors that carry unit vectors to others, (n, 3), and angles, (n,) [rad].

    Opposite vectors have an angle of pi, and no rotation vector.
    """
    normals = np.cross(axes, others)
    sines = np.linalg.norm(normals, axis=1)
    angles = np.arctan2(sines, np.sum(axes * others, axis=1))
    return normals * (angles / np.maximum(sines, TINY))[:, None], angles


def _with_places(
    model: Path,
    places: Mapping[str, np.ndarray],
    last: str,
    sites: Mapping[str, np.ndarray],
) -> tuple[Path, bytes]:
    """Return the one file that holds some bodies, with other poses on their parents, (4, 4).

    The last body gets sites, by name, of poses in its frame.
    """
    for file, data, begins in _files(model, model.parent, places):
        if len(begins) < len(places):
            continue
        edits: list[tuple[int, int, bytes]] = []
        for body, begin in begins.items():
            end = end_of_tag(data, begin)
            tag = _placed(_TURNS.sub(b"", data[begin:end]), places[body])
            if body == last:
                tags = [
                    _placed(f"<site name={quoteattr(name)}/>".encode(), T)
                    for name, T in sites.items()
                ]
                tag = b"\n".join([tag, *tags])
            edits.append((begin, end, tag))
        return file, with_edits(data, edits)
    raise ExportError(
        f"{model}: neither it nor a file that it includes holds all bodies of the arm: "
        f"{', '.join(body or '(one without a name)' for body in places)}"
    )


def _placed(tag: bytes, T: np.ndarray) -> bytes:
    """Return a tag with another pose, (4, 4)."""
    import mujoco

    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    numbers = {"pos": T[:3, 3], "quat": quat}
    words = {key: " ".join(map(repr, v.tolist())) for key, v in numbers.items()}
    return with_attributes(tag, words)


def _files(
    file: Path, folder: Path, places: Mapping[str, np.ndarray]
) -> Iterator[tuple[Path, bytes, dict[str, int]]]:
    """Yield a model and what it includes: each file, its text, and where bodies begin in it."""
    data = read_bytes(file, LARGEST_DOCUMENT)
    begins: dict[str, int] = {}
    included: list[str] = []
    path: list[str] = []
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "include":
            included.append(attributes.get("file", ""))
        if tag == "body" and attributes.get("name") in places:
            name = attributes["name"]
            if {"frame", "replicate"} & set(path):
                raise ExportError(f"{file}: body {name!r} hangs in a <frame>")
            begins[name] = parser.CurrentByteIndex
        path.append(tag)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: path.pop()
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:  # MuJoCo is more lenient
        raise ExportError(f"{file}: not well-formed XML: {error}") from None
    yield file, data, begins
    for name in included:
        for place in (folder, file.parent):
            if (place / name).is_file():
                yield from _files(place / name, folder, places)
                break

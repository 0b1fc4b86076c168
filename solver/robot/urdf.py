"""The kinematic chain of a robot, from its base to the ball, as a URDF describes it."""

import hashlib
import io
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .urdf_text import ModelError, Origin, UrdfText, add_ball, scan

if TYPE_CHECKING:
    import yourdfpy  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["BALL_LINK", "Body", "Joint", "Robot", "load_robot", "parse_robot", "shipped_robots"]

BALL_LINK = "ball_link"
_CALIBRATED = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Joint:
    """A joint of the chain."""

    name: str
    type: str
    """``revolute``, ``continuous``, ``prismatic`` or ``fixed``."""
    parent: str
    child: str
    origin: Origin
    axis: tuple[float, float, float]
    """Unit vector in the joint's own frame; means nothing where the joint is fixed."""
    lower: float = -math.inf
    """Lower limit [rad], [m] for a prismatic joint; minus infinity where there is none."""
    upper: float = math.inf

    @property
    def actuated(self) -> bool:
        """Whether the joint moves."""
        return self.type != "fixed"


@dataclass(frozen=True)
class Body:
    """A mass that moves with a link of the chain."""

    joint: int
    """Index of the chain's joint whose child link carries it."""
    mass: float
    """[kg]."""
    centre: tuple[float, float, float]
    """Centre of mass in that link's frame [m]."""


@dataclass(frozen=True)
class Robot:
    """A nominal robot: its joints in order from the base to the ball, and the URDF's text.

    All lengths are metres and all angles radians.
    """

    name: str
    """The robot's name."""
    source: str
    """The file, or the name of a shipped robot."""
    text: UrdfText
    base: str
    tip: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    loaded_with: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """The other arguments that :func:`load_robot` was called with, so that it can load it again."""

    def __repr__(self) -> str:
        return (
            f"<Robot {self.name!r}: {len(self.actuated)} joints, {self.base} -> {self.tip}, "
            f"from {self.source}>"
        )

    @cached_property
    def actuated(self) -> tuple[Joint, ...]:
        """The joints that move, in order: the columns of a recording."""
        return tuple(joint for joint in self.joints if joint.actuated)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that move."""
        return tuple(joint.name for joint in self.actuated)

    @property
    def ball_joint(self) -> Joint:
        """The fixed joint that carries the ball."""
        return self.joints[-1]

    @property
    def sha256(self) -> str:
        """Digest of the URDF's text, by which a recording knows its model."""
        return hashlib.sha256(self.text.data).hexdigest()

    @property
    def origins(self) -> np.ndarray:
        """Origins of all joints as written, shape (joints, 6): x y z [m], roll pitch yaw [rad]."""
        return np.array([joint.origin.xyz + joint.origin.rpy for joint in self.joints], dtype=float)


def shipped_robots() -> dict[str, Path]:
    """Return the robots that come with the package: name and file."""
    folder = Path(str(files("mukca.solver.robot"))) / "shipped"
    return {file.stem: file for file in sorted(folder.glob("*.urdf"))}


def load_robot(
    robot: str | Path,
    *,
    base: str | None = None,
    tip: str = BALL_LINK,
    flange: str | None = None,
    ball: Sequence[float] | None = None,
) -> Robot:
    """Read a robot: one that comes with the package, or a URDF file.

    Args:
        robot: Name of a shipped robot, such as ``panda``, or path of a URDF file.
        base: The base link; None for the model's root.
        tip: The link whose origin is the ball's centre.
        flange: For a URDF without a ball: the link that carries it. A new link, with the name
            ``tip``, is then fixed to that one.
        ball: With ``flange``: the ball's centre in that link's frame, x y z [m].

    Raises:
        ModelError: No such robot or link, the file is not a URDF with such a chain, or one of
            ``flange`` and ``ball`` is there without the other.
    """
    if (flange is None) != (ball is None):
        raise ModelError("--flange LINK and --ball X Y Z go together: a link, and the ball on it")
    name = str(robot)
    file = shipped_robots().get(name, Path(name))
    try:
        data = file.read_bytes()
    except OSError as error:
        shipped = ", ".join(shipped_robots())
        reason = error.strerror or "cannot be read"
        raise ModelError(
            f"robot {name!r}: {reason}; give the path of a URDF file, or one of: {shipped}"
        ) from None
    text = scan(data, str(file))
    if flange is not None and ball is not None:
        _require_link(text, flange, str(file))
        text = scan(add_ball(text, flange, _three_numbers(ball), tip), str(file))
    loaded = parse_robot(text, source=name, base=base, tip=tip)
    place = None if ball is None else list(ball)
    return replace(loaded, loaded_with={"base": base, "tip": tip, "flange": flange, "ball": place})


def _three_numbers(ball: Sequence[float]) -> tuple[float, float, float]:
    numbers = tuple(map(float, ball))
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ModelError(f"ball {list(ball)}: give its centre as three finite numbers, x y z in m")
    return numbers


def parse_robot(
    text: UrdfText, *, source: str, base: str | None = None, tip: str = BALL_LINK
) -> Robot:
    """Read the chain from a model's text; see :func:`load_robot`.

    Raises:
        ModelError: The text has no such chain.
    """
    model = _parse(text, source)
    parents = _parent_joints(model, text, source)
    root = _root(text, parents, source)
    _require_link(
        text,
        tip,
        source,
        hint="; name the ball's link by --tip, or put a ball on a "
        "link by --flange LINK --ball X Y Z",
    )
    base = base or root
    _require_link(text, base, source)
    path = _path(parents, base, tip, source)
    joints = tuple(_joint(joint, text.origins[joint.name], source) for joint in path)
    if not any(joint.actuated for joint in joints):
        raise ModelError(f"{source}: no joint moves between {base!r} and {tip!r}")
    if joints[-1].actuated:
        raise ModelError(
            f"{source}: {tip!r} hangs on the moving joint {joints[-1].name!r}; the ball must be "
            f"fixed to a link: --flange {tip} --ball X Y Z"
        )
    bodies = _bodies(model, parents, joints)
    return Robot(model.robot.name, source, text, base, tip, joints, bodies)


def _parse(text: UrdfText, source: str) -> "yourdfpy.URDF":
    import yourdfpy  # pyright: ignore[reportMissingTypeStubs]

    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)
    try:
        return yourdfpy.URDF.load(  # pyright: ignore[reportUnknownMemberType]
            io.BytesIO(text.data), build_scene_graph=False, load_meshes=False
        )
    except Exception as error:  # whatever the reader stumbles over, the file is to blame
        raise ModelError(f"{source}: not a valid URDF: {error or type(error).__name__}") from None


def _parent_joints(model: Any, text: UrdfText, source: str) -> dict[str, Any]:
    """Return the joint above each link; each link has one at most."""
    parents: dict[str, Any] = {}
    for joint in model.robot.joints:
        for link in (joint.parent, joint.child):
            if link not in text.links:
                raise ModelError(f"{source}: joint {joint.name!r} names a missing link {link!r}")
        if joint.child in parents:
            raise ModelError(
                f"{source}: link {joint.child!r} has two parents, joints "
                f"{parents[joint.child].name!r} and {joint.name!r}: a loop, where a tree is needed"
            )
        parents[joint.child] = joint
    return parents


def _root(text: UrdfText, parents: dict[str, Any], source: str) -> str:
    roots = [link for link in text.links if link not in parents]
    if not roots:
        raise ModelError(f"{source}: no root link, the joints form a loop where a tree is needed")
    if len(roots) > 1:
        raise ModelError(
            f"{source}: {len(roots)} links have no parent ({', '.join(roots[:4])}); "
            "a robot has one root, so join them by fixed joints"
        )
    return roots[0]


def _require_link(text: UrdfText, link: str, source: str, hint: str = "") -> None:
    if link not in text.links:
        some = ", ".join(text.links[-6:]) or "none"
        raise ModelError(f"{source}: no link is called {link!r}{hint} (last links: {some})")


def _path(parents: dict[str, Any], base: str, tip: str, source: str) -> list[Any]:
    """Return the joints from base to tip, in that order."""
    joints: list[Any] = []
    link = tip
    while link != base:
        if link not in parents:
            raise ModelError(f"{source}: {tip!r} is not below {base!r}; choose another --base")
        if len(joints) > len(parents):
            raise ModelError(f"{source}: the joints above {tip!r} form a loop")
        joints.append(parents[link])
        link = parents[link].parent
    return joints[::-1]


def _joint(joint: Any, origin: Origin, source: str) -> Joint:
    where = f"{source}: joint {joint.name!r}"
    if joint.type not in (*_CALIBRATED, "fixed"):
        raise ModelError(f"{where} is {joint.type}, which a chain to calibrate cannot have")
    if joint.type != "fixed" and joint.mimic is not None:
        raise ModelError(f"{where} mimics {joint.mimic.joint!r}; a chain's joint must move freely")
    lower, upper = _limits(joint)
    if not lower <= upper:
        raise ModelError(f"{where}: its limits {lower} to {upper} leave no room")
    # A joint that does not move has no axis, whatever is written there.
    axis = (1.0, 0.0, 0.0) if joint.type == "fixed" else _axis(joint.axis, where)
    return Joint(joint.name, joint.type, joint.parent, joint.child, origin, axis, lower, upper)


def _axis(written: Any, where: str) -> tuple[float, float, float]:
    """Return the unit vector along a written axis."""
    axis = np.asarray(written, dtype=float)
    length = float(np.linalg.norm(axis))
    if axis.shape != (3,) or not math.isfinite(length) or length < 1e-9:
        raise ModelError(f"{where}: axis {axis.tolist()} is no direction")
    x, y, z = (axis / length).tolist()
    return x, y, z


def _limits(joint: Any) -> tuple[float, float]:
    lower, upper = (joint.limit.lower, joint.limit.upper) if joint.limit else (None, None)
    if joint.type in ("continuous", "fixed") or (lower is None and upper is None):
        return (-math.inf, math.inf)
    return (0.0 if lower is None else lower, 0.0 if upper is None else upper)


def _bodies(model: Any, parents: dict[str, Any], joints: tuple[Joint, ...]) -> tuple[Body, ...]:
    """Return all masses that the chain moves; joints beside it, as of a gripper, are at zero."""
    index = {joint.child: i for i, joint in enumerate(joints)}
    bodies: list[Body] = []
    for link in model.robot.links:
        inertial = link.inertial
        if inertial is None or not inertial.mass:
            continue
        place = np.eye(4) if inertial.origin is None else np.asarray(inertial.origin)
        name = link.name
        while name not in index and name in parents:
            joint = parents[name]
            place = (np.eye(4) if joint.origin is None else np.asarray(joint.origin)) @ place
            name = joint.parent
        if name in index:
            x, y, z = place[:3, 3].tolist()
            bodies.append(Body(index[name], float(inertial.mass), (x, y, z)))
    return tuple(bodies)

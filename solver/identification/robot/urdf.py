"""The kinematic model of a robot, from its base to the ball, as a URDF describes it."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import LARGEST_DOCUMENT, LENGTH, MASS, ON_FLANGE, ROTATION, read_bytes
from .bodies import Body, crude_bodies, find_bodies
from .chain import Joint, find_chain, find_root, require_link
from .urdf_edits import add_link
from .urdf_text import ModelError, Origin, UrdfText, Vector, scan

BALL_LINK = "ball_link"
HEAVIEST = 300.0
"""No arm moves more mass than this for each square metre of its reach [kg/m^2]."""
LEAST_REACH = 1.0
"""A ball may be that far from its link, however small the arm [m]."""
OWN_BALL = "printed_ball"
"""Link of a ball that the user puts on a model that has one already."""


@dataclass(frozen=True)
class Robot:
    """A nominal robot: its joints in order from the base to the ball, and the URDF's text.

    All lengths are metres and all angles radians.
    """

    name: str
    source: str
    """The file, or the name of a shipped robot."""
    text: UrdfText
    base: str
    tip: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    """Its masses; crude ones where the URDF states none, see :attr:`masses_assumed`."""
    loaded_with: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """The other arguments that :func:`load_robot` was called with, so that it can load it again."""
    masses_assumed: bool = False
    """True for a URDF without masses: torques are right but for a common factor then."""

    def __repr__(self) -> str:
        return (
            f"<Robot {self.name!r}: {len(self.actuated)} joints, {self.base} -> {self.tip}, "
            f"from {self.source}>"
        )

    @cached_property
    def actuated(self) -> tuple[Joint, ...]:
        """The joints that move, in order: the columns of a recording."""
        return tuple(joint for joint in self.joints if joint.actuated)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that move."""
        return tuple(joint.name for joint in self.actuated)

    @cached_property
    def lower(self) -> np.ndarray:
        """Least positions of the joints that move, shape (m,) [rad]; -inf for no limit."""
        return np.array([joint.lower for joint in self.actuated])

    @cached_property
    def upper(self) -> np.ndarray:
        """Largest positions of the joints that move, shape (m,) [rad]."""
        return np.array([joint.upper for joint in self.actuated])

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
        rows = [joint.origin.numbers for joint in self.joints]
        return np.array(rows, dtype=float)

    @property
    def ball_unknown(self) -> bool:
        """True where a link carries a ball, and nobody said where on it."""
        return bool(self.loaded_with.get("flange")) and not self.loaded_with["ball"]

    def with_origins(self, origins: np.ndarray) -> "Robot":
        """Return the robot with other joint origins, as :attr:`origins`; its text stays."""
        pairs = zip(self.joints, origins, strict=True)
        joints: list[Joint] = []
        for joint, row in pairs:
            joints.append(replace(joint, origin=Origin.of(row)))
        return replace(self, joints=tuple(joints))

    def carrying(self, mass: float, centre: Sequence[float]) -> "Robot":
        """Return the robot with one more mass [kg] at a point of the flange, x y z [m].

        Raises:
            ModelError: A negative mass, or numbers that are not finite.
        """
        if not (math.isfinite(mass) and mass >= 0):
            raise ModelError(f"payload: a mass of {mass} kg; give zero or more")
        place = _three_numbers(centre, "payload")
        if doubt := ON_FLANGE.doubt(place):
            raise ModelError(f"payload: its centre {list(place)}: {doubt}")
        flange = len(self.joints) - 2
        body = Body(flange, float(mass), place)
        return replace(self, bodies=(*self.bodies, body))


def shipped_robots() -> dict[str, Path]:
    """Return the robots that come with the package: name and file."""
    folder = Path(str(files("mukca.solver.identification.robot"))) / "shipped"
    models = sorted(folder.glob("*.urdf"))
    return {file.stem: file for file in models}


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
        flange: For a ball of one's own: the link that carries it. A new link, with the name
            ``tip``, is then fixed to that one; where the model has a ``ball_link`` already, it is
            called ``printed_ball``.
        ball: With ``flange``: the ball's centre in that link's frame, x y z [m]; None for one that
            an instrument measures, which is found wherever it sits.

    Raises:
        ModelError: No such robot or link, the file is not a URDF with such a chain, or ``ball`` is
            there without ``flange``.
    """
    if flange is None and ball is not None:
        raise ModelError("ball without flange: name the link that carries it")
    text = scan(_model(robot), str(robot))
    centre = None if ball is None else _three_numbers(ball, "ball")
    if flange is not None:
        tip = OWN_BALL if tip == BALL_LINK and tip in text.links else tip
        text = _with_ball(text, flange, Origin(centre or (0.0, 0.0, 0.0)), tip)
    loaded = parse_robot(text, base=base, tip=tip)
    place = None if centre is None else list(centre)
    loaded_with = {"base": base, "tip": tip, "flange": flange, "ball": place}
    return replace(loaded, loaded_with=loaded_with)


def _model(robot: str | Path) -> bytes:
    """Return the URDF of a robot that comes with the package, or of a file."""
    shipped = shipped_robots()
    name = str(robot)
    try:
        return read_bytes(shipped.get(name, Path(name)), LARGEST_DOCUMENT)
    except (OSError, ValueError) as error:
        # ValueError: a path with a zero
        reason = getattr(error, "strerror", None) or "cannot be read"
        similar = get_close_matches(name.lower(), shipped, n=1)
        question = f", did you mean {similar[0]!r}?" if similar else ""
        raise ModelError(
            f"robot {name!r}: {reason}{question}; give the path of a URDF file, or one of: "
            f"{', '.join(shipped)}"
        ) from None


def _with_ball(
    text: UrdfText,
    flange: str,
    origin: Origin,
    link: str,
) -> UrdfText:
    """Return a model with a ball of one's own on a link."""
    require_link(text, flange)
    try:
        data = add_link(text, flange, origin, link)
        return scan(data, text.source)
    except ModelError as error:
        raise ModelError(
            f"{error}; leave out --flange, or give the new ball another name, as in "
            "--tip printed_ball"
        ) from None


def _three_numbers(point: Sequence[float], what: str) -> Vector:
    """Return a point as three finite numbers."""
    try:
        x, y, z = map(float, point)
    except (TypeError, ValueError):
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        words = list(point) if isinstance(point, list | tuple) else point
        raise ModelError(
            f"{what} {words}: give its centre as three finite numbers, x y z in m"
        )
    return x, y, z


def parse_robot(
    text: UrdfText,
    *,
    base: str | None = None,
    tip: str = BALL_LINK,
) -> Robot:
    """Read the chain from a model's text; see :func:`load_robot`.

    Raises:
        ModelError: The text has no such chain.
    """
    root = find_root(text)
    hint = "; name the ball's link by --tip, or put a ball on a link by --flange LINK --ball X Y Z"
    require_link(text, tip, hint)
    base = base or root
    require_link(text, base)
    joints = find_chain(text, base, tip)
    if not any(joint.actuated for joint in joints):
        raise ModelError(f"{text.source}: no joint moves between {base!r} and {tip!r}")
    if joints[-1].actuated:
        raise ModelError(
            f"{text.source}: {tip!r} hangs on the moving joint {joints[-1].name!r}; the ball must "
            f"be fixed to a link: --flange {tip} --ball X Y Z"
        )
    bodies = find_bodies(text, joints)
    _check_sizes(text.source, joints, bodies)
    return Robot(
        text.name,
        text.source,
        text,
        base,
        tip,
        joints,
        bodies or crude_bodies(joints),
        masses_assumed=not bodies,
    )


def _check_sizes(
    source: str,
    joints: Sequence[Joint],
    bodies: Sequence[Body],
) -> None:
    """Refuse a chain in degrees, in millimetres or in grams."""
    for joint in joints:
        origin = joint.origin
        doubt = ROTATION.doubt(origin.rpy) or LENGTH.doubt(origin.xyz)
        if doubt:
            raise ModelError(f"{source}: origin of joint {joint.name!r}: {doubt}")
    *lengths, length_of_tip = [math.hypot(*joint.origin.xyz) for joint in joints]
    reach = max(sum(lengths), LEAST_REACH)
    if doubt := ON_FLANGE.doubt([length_of_tip], reach):
        raise ModelError(
            f"{source}: {joints[-1].child!r} is farther from its link than the arm reaches, {doubt}"
        )
    mass = sum(body.mass for body in bodies)
    if doubt := MASS.doubt([mass], HEAVIEST * reach**2):
        raise ModelError(f"{source}: the masses that the arm moves sum up to {doubt}")

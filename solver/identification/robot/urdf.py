"""The kinematic model of a robot, from its base to the ball, as a URDF describes it."""

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import LENGTH, MASS, ON_FLANGE, ROTATION
from .bodies import Body, crude_bodies, find_bodies
from .chain import Joint, find_chain, find_root, require_link
from .urdf_text import ModelError, Origin, UrdfText, Vector

BALL_LINK = "ball_link"
HEAVIEST = 300.0
"""No arm moves more mass than this for each square metre of its reach [kg/m^2]."""
LEAST_REACH = 1.0
"""A ball may be that far from its link, however small the arm [m]."""


@dataclass(frozen=True)
class Robot:
    """A nominal robot: its joints in order from the base to the ball, and the URDF's text.

    All lengths are metres and all angles radians.
    """

    name: str
    source: str
    """The file, or the name of a shipped robot; see also :func:`urdf_of`."""
    text: UrdfText
    base: str
    tip: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    """Its masses; crude ones where the URDF states none, see :attr:`masses_assumed`."""
    loaded_with: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """The other arguments of :func:`.model_file.load_robot`, so that it can load it again."""
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
        place = three_numbers(centre, "payload")
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


def urdf_of(source: str) -> str:
    """Return what a robot's source names as its URDF, without a YAML file that is added to it."""
    both = re.fullmatch(r"(.+)\+.+\.ya?ml", source)
    return both[1] if both else source


def three_numbers(point: Sequence[float], what: str) -> Vector:
    """Return a point as three finite numbers.

    Raises:
        ModelError: It is none.
    """
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
    """Read the chain from a model's text; see :func:`.model_file.load_robot`.

    Raises:
        ModelError: The text has no such chain.
    """
    root = find_root(text)
    require_link(text, tip)
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

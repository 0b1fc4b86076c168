"""The parameters of a calibration: free numbers of the joint origins, and their names.

A parameter is called ``JOINT.x``, ``.y``, ``.z`` [m], as in the joint's ``<origin>``, or
``JOINT.roll``, ``.pitch``, ``.yaw`` [rad]: the turn of the joint's frame about its own x, y and z
axis, together a rotation vector. By the paper's method these are the origin's own angles.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import chain, product

from ....errors import MukcaError
from .urdf import Robot

COMPONENTS = ("x", "y", "z", "roll", "pitch", "yaw")
_GROUPS = {"xyz": COMPONENTS[:3], "rpy": COMPONENTS[3:]}


class ParameterError(MukcaError):
    """A name given to free or to fix is not a parameter."""


@dataclass(frozen=True)
class Parameter:
    """One number of one joint's origin."""

    joint: str
    component: str
    """One of :data:`COMPONENTS`."""
    index: int
    """Its index in ``robot.origins.ravel()``: six numbers for each joint, in chain order."""
    of_ball: bool
    """True for the ball's place on the flange, which was only guessed: it may change freely, while
    other parameters are held near nominal."""

    @property
    def name(self) -> str:
        """``JOINT.COMPONENT``."""
        return f"{self.joint}.{self.component}"

    @property
    def unit(self) -> str:
        """``m`` or ``rad``."""
        return "m" if self.component in _GROUPS["xyz"] else "rad"


def choose_parameters(
    robot: Robot,
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
) -> tuple[Parameter, ...]:
    """Return the free parameters, in chain order.

    Args:
        robot: The robot.
        free: Free parameters, as joint names, ``JOINT.x``, ``JOINT.xyz`` or ``JOINT.rpy``; ``*``
            stands for any text. Empty: all actuated joints and the ball.
        fix: Fixed ones, by the same words.

    Raises:
        ParameterError: A word that fits nothing, or nothing remains free.
    """
    parameters = all_parameters(robot)
    default = {joint.name for joint in robot.actuated} | {robot.ball_joint.name}
    selection = [p for p in parameters if p.joint in default]
    if free:
        matches = set(chain.from_iterable(_matching(parameters, word) for word in free))
        selection = [p for p in parameters if p in matches]
    unwanted = set(chain.from_iterable(_matching(parameters, word) for word in fix))
    selection = [p for p in selection if p not in unwanted]
    if not selection:
        raise ParameterError(
            "nothing is left free; a calibration needs at least one parameter"
        )
    return tuple(selection)


def all_parameters(robot: Robot) -> list[Parameter]:
    """Return every number of every joint origin, in chain order."""
    return [
        Parameter(joint.name, component, 6 * i + k, of_ball=joint is robot.ball_joint)
        for (i, joint), (k, component) in product(
            enumerate(robot.joints), enumerate(COMPONENTS)
        )
    ]


def _matching(
    parameters: Sequence[Parameter],
    word: str,
) -> list[Parameter]:
    joint, _, component = word.rpartition(".")
    parts = _GROUPS.get(component, (component,))
    matching = [p for p in parameters if fnmatchcase(p.joint, word)] or [
        p for p in parameters if fnmatchcase(p.joint, joint) and p.component in parts
    ]
    if not matching:
        joints = ", ".join(dict.fromkeys(p.joint for p in parameters))
        raise ParameterError(
            f"{word!r} is no joint or parameter of this chain; joints: {joints}; "
            f"components: {', '.join(COMPONENTS)}, xyz, rpy"
        )
    return matching

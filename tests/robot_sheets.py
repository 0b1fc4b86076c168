"""What the tests of shipped robots share: data sheets, and the files as other libraries read them.

Nothing here uses mukca's own reader or kinematics.
"""

import json
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy
from imagined import poses

FOLDER = Path(str(files("mukca.solver.identification.robot") / "shipped"))


@dataclass(frozen=True)
class DataSheet:
    """What the maker publishes of one arm; robot_sheets.json has them all."""

    joints: list[str]
    flange: str
    "The link whose origin is the face of the flange."
    mass: float | None = None
    "Weight of the whole arm, base included [kg]; None where no data sheet was at hand."
    end_effector_mass: float = 0.0
    "What the model carries besides the arm [kg]."
    base: str = "base_link"
    out: int = 2
    "The flange's axis that points away from the arm: 0, 1, 2 for x, y, z."
    sign: int = 1
    "-1 where it points the other way."
    aside: tuple[float, float] = (0.0, 0.0)
    "The ball's place along the flange's other two axes [m]."
    dh: dict[str, Any] | None = None
    """The maker's table: rows of theta, d, a and alpha [deg, m]; its convention, ``dh`` or ``mdh``,
    Craig's modified one; by what its base is turned about z [deg], and the tool behind it [m].
    Franka's FCI documentation; Universal Robots' article on DH parameters; Kinova's user guide,
    "Classical DH parameters", to the interface module; of the iiwa14 the data sheet's drawing; of
    the iiwa7 the same with its lengths, of which no data sheet was at hand."""
    bodies: list[list[float]] | None = None
    "Masses and centres of mass of links 1 to 6 in the frames of that table, same source [kg, m]."
    landmarks: list[dict[str, Any]] = field(default_factory=list)
    "Where links stand by drawings and examples at joint positions q [deg, m]."
    makers_model: list[float] | None = None
    """Where the flange, or the tip, of the maker's own model stands with all joints at zero, and
    with them at 0.1, 0.2, 0.3, ... rad, there with its orientation as a quaternion x y z w. Worked
    out by pinocchio from the file, whose angles of pi/2 are rounded: 8 um and 26 urad at most."""


SHEETS_FILE = Path(__file__).with_suffix(".json")
DATA_SHEETS = {k: DataSheet(**v) for k, v in json.loads(SHEETS_FILE.read_text()).items()}
NAMES = sorted(DATA_SHEETS)


def having(fact):
    """The names of the arms of which a fact is published."""
    return [name for name in NAMES if getattr(DATA_SHEETS[name], fact)]


def path_of(name):
    return FOLDER / f"{name}.urdf"


def load(name):
    return yourdfpy.URDF.load(
        str(path_of(name)),
        load_meshes=False,
        build_scene_graph=False,
        load_collision_meshes=False,
        build_collision_scene_graph=False,
    )


def chain(name):
    """The joints from the root to the ball, which must be all joints of the file."""
    by_child = {joint.child: joint for joint in load(name).robot.joints}
    link, found = "ball_link", list[yourdfpy.Joint]()
    while link in by_child:
        found.insert(0, by_child[link])
        link = by_child[link].parent
    return found


def inertials(name):
    links = load(name).robot.links
    return {link.name: link.inertial for link in links if link.inertial is not None}


def pose(name, link, q):
    """4 x 4 pose of a link in base_link, by pinocchio."""
    return poses(path_of(name).read_text(), link, [np.asarray(q, dtype=float)])[0]


def random_configurations(name, count=20):
    rng = np.random.default_rng(7)
    limits = [joint.limit for joint in chain(name) if joint.type != "fixed"]
    low, high = [x.lower for x in limits], [x.upper for x in limits]
    return rng.uniform(low, high, (count, len(limits)))

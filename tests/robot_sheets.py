"""What the tests of shipped robots share: data sheets, and the files as other libraries read them.

Nothing here uses mukca's own reader or kinematics.
"""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
import pinocchio
import yourdfpy

FOLDER = Path(str(files("mukca.solver.robot") / "shipped"))


@dataclass(frozen=True)
class DataSheet:
    """What the maker publishes of one arm."""

    joints: tuple[str, ...]
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


def numbered(pattern, count):
    return tuple(pattern.format(i) for i in range(1, count + 1))


UR_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
LEROBOT_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
INTERBOTIX_JOINTS = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate")
DATA_SHEETS = {
    "panda": DataSheet(numbered("panda_joint{}", 7), "panda_link8", 18.0, 0.73),
    "fr3": DataSheet(numbered("fr3_joint{}", 7), "fr3_link8", 17.8, 0.73),
    "iiwa14": DataSheet(numbered("joint_a{}", 7), "tool0", 29.9),
    "gen3_lite": DataSheet(numbered("joint_{}", 6), "end_effector_link", 5.4),
    "ur3e": DataSheet(UR_JOINTS, "tool0", 11.2),
    "ur5e": DataSheet(UR_JOINTS, "tool0", 20.6),
    "ur10e": DataSheet(UR_JOINTS, "tool0", 33.5),
    "so101": DataSheet(LEROBOT_JOINTS, "gripper_frame_link", aside=(-0.02, 0.0)),
    "so100": DataSheet(LEROBOT_JOINTS, "gripper", base="base", out=1, sign=-1),
    "vx300s": DataSheet(INTERBOTIX_JOINTS, "ee_gripper_link", out=0),
    "wx250s": DataSheet(INTERBOTIX_JOINTS, "ee_gripper_link", out=0),
    "koch": DataSheet(numbered("joint_{}", 5), "link_5", out=0, sign=-1),
    "xarm6": DataSheet(numbered("joint{}", 6), "link_eef", base="link_base"),
    "xarm7": DataSheet(numbered("joint{}", 7), "link_eef", base="link_base"),
    "lite6": DataSheet(numbered("joint{}", 6), "link_eef", base="link_base"),
    "uf850": DataSheet(numbered("joint{}", 6), "link_eef", base="link_base"),
    "ur3": DataSheet(UR_JOINTS, "tool0"),
    "ur5": DataSheet(UR_JOINTS, "tool0"),
    "ur10": DataSheet(UR_JOINTS, "tool0"),
    "ur20": DataSheet(UR_JOINTS, "tool0"),
    "openarm": DataSheet(
        numbered("openarm_right_joint{}", 7),
        "openarm_right_hand_tcp",
        base="openarm_right_link0",
    ),
    "wxai": DataSheet(tuple(f"joint_{i}" for i in range(6)), "ee_gripper_link", out=0),
    "gen3": DataSheet(numbered("joint_{}", 7), "end_effector_link"),
    "piper": DataSheet(numbered("joint{}", 6), "link6"),
}
NAMES = sorted(DATA_SHEETS)


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
    model = pinocchio.buildModelFromUrdf(str(path_of(name)))
    data = model.createData()
    assert model.existFrame(link)
    pinocchio.framesForwardKinematics(model, data, np.asarray(q, dtype=float))
    return np.array(data.oMf[model.getFrameId(link)].homogeneous)


def random_configurations(name, count=20):
    rng = np.random.default_rng(7)
    limits = [joint.limit for joint in chain(name) if joint.type != "fixed"]
    low, high = [x.lower for x in limits], [x.upper for x in limits]
    return rng.uniform(low, high, (count, len(limits)))

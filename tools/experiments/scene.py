"""The arm as it truly is, its tool, and what it touches, in MuJoCo."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import ArrayLike

from ...solver.identification.robot import Robot, set_origins
from ..simulation import horizontal

HIDDEN = 3
"""Group of what is touched but not shown."""
OPEN_TO = -50.0
"""Direction on the table in which the block is cut open, from the hole [degrees]."""
CUT = 110.0
"""Angle of the cut [degrees]."""
SLICES = 40
TOOL = 0.08
"""Length before the tip without an arm, so that peg or pen are seen [m]."""
SHADOW = 1024
"""Of a lamp's map of shadows, to a side; MuJoCo's 4096 take a processor twice as long [pixels]."""
ORANGE = [0.85, 0.3, 0.1, 1]
DARK = [0.25, 0.28, 0.32, 1]
LIGHT = [0.9, 0.9, 0.92, 1]
BLUE = [0.3, 0.5, 0.7, 1]


def add_visuals(spec: Any, arm: Robot) -> None:
    """Add a pale sky, a lamp, a capsule from each joint to the next, and a drum on each joint."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        width=64,
        height=384,
        rgb1=[0.97, 0.98, 0.99],
        rgb2=[0.85, 0.88, 0.91],
    )
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.quality.shadowsize = SHADOW
    # A picture is rendered larger, which takes half as long.
    spec.visual.quality.offsamples = 0
    spec.worldbody.add_light(pos=[0.3, -1.0, 2.0], dir=[0.1, 0.5, -1.0])
    for joint, end in zip(arm.joints, _link_ends(arm), strict=False):
        body = spec.body(joint.child)
        if joint.actuated:
            _ghost(body, "cylinder", [0.055, 0.06], rgba=DARK)
        if np.linalg.norm(end) > 0.02:
            _ghost(
                body,
                "capsule",
                [0.04],
                fromto=[0, 0, 0, *end],
                rgba=LIGHT,
            )


def _link_ends(arm: Robot) -> np.ndarray:
    """Return where each link's capsule ends in the link's frame, TOOL before the tip [m]."""
    ends = np.array([joint.origin.xyz for joint in arm.joints[1:]])
    lengths = np.linalg.norm(ends, axis=1)
    to_tip = np.cumsum(lengths[::-1])[::-1] - lengths
    hidden = (TOOL - to_tip) / np.maximum(lengths, 1e-9)
    return ends * np.clip(1 - hidden, 0, 1)[:, None]


def add_stem(body: Any, end: float) -> None:
    """Add a peg's or pen's cylinder up to a height on the z axis [m]."""
    axis = [0, 0, -PEG_LENGTH, 0, 0, end]
    _ghost(
        body,
        "cylinder",
        [PEG_RADIUS],
        fromto=axis,
        rgba=ORANGE,
    )


def add_open_block(spec: Any, body: Any, inner: float, outer: float) -> None:
    """Add a block with a hole, by their radii [m], cut open so that the peg is seen."""
    bottom, top = (
        [(inner, 0.0), (outer, 0.0)],
        [(outer, HOLE_DEPTH), (inner, HOLE_DEPTH)],
    )
    profile = [*bottom, *top, bottom[0]]
    angle = np.radians(360 - CUT)
    creation: Any = trimesh.creation
    block = creation.revolve(profile, angle, cap=True, sections=SLICES)
    spec.add_mesh(
        name="block",
        uservert=np.ravel(block.vertices),
        userface=np.ravel(block.faces),
        smoothnormal=0,
    )
    turn = _about_z(np.radians(OPEN_TO + CUT / 2))
    _ghost(
        body,
        "mesh",
        [],
        meshname="block",
        quat=turn,
        rgba=BLUE,
    )


def _about_z(angle: float) -> list[float]:
    """Return the quaternion of a turn about z [rad]."""
    return [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]


def _geom(body: Any, kind: str, size: Sequence[float], **more: Any) -> None:
    """Add a shape, by MuJoCo's word for its kind, and its sizes [m]."""
    shape = getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}")
    body.add_geom(type=shape, size=[*size, 0, 0, 0][:3], **more)


def _ghost(body: Any, kind: str, size: Sequence[float], **more: Any) -> None:
    """Add a shape that is only seen."""
    _geom(
        body,
        kind,
        size,
        contype=0,
        conaffinity=0,
        mass=0,
        **more,
    )


TIME_STEP = 1e-3
"""Of the physics, and of the controller [s]."""
JOINT_FRICTION = 0.2
"""Coulomb friction of each joint, an assumption; it is what the compensator is for [N m]."""
ROTOR_INERTIA = 0.1
"""Of each motor, as the joint feels it through the gear [kg m^2]."""
TABLE = 0.08
"""Height of the table above the arm's base [m]."""
PEG_RADIUS = 5e-3
PEG_FILLET = 1e-3
"""Rounding of the peg's edge [m]."""
PEG_LENGTH = 0.04
HOLE_DEPTH = 0.02
HOLE_SIDES = 24
ANGLES = np.arange(HOLE_SIDES) * 2 * np.pi / HOLE_SIDES
HOLE_WALL = 0.06
"""From the hole's edge to the rim of the block around it [m]."""
TOUCH: dict[str, Any] = {"priority": 1, "mass": 0}
PEG_TOUCH = {**TOUCH, "friction": [0.3, 0, 0], "solref": [5 * TIME_STEP, 1]}
"""Plastic on plastic; much stiffer, and the peg would hop along the wall."""
PEN_TOUCH = {
    **TOUCH,
    "friction": [0.2, 0, 0],
    "solref": [0.05, 1],
    "solimp": [0.5, 0.9, 2e-3, 0.5, 2],
}
"""A felt tip on paper: it yields by a millimetre, or it would hop."""


def urdf_of(robot: Robot) -> bytes:
    """Return a chain's model with the origins that its joints have now."""
    origins = {joint.name: joint.origin for joint in robot.joints}
    return set_origins(robot.text, origins)


def _spec_of(arm: Robot) -> Any:
    """Return an arm with its motors and their friction, as MuJoCo is told of it."""
    spec = mujoco.MjSpec.from_string(urdf_of(arm).decode())
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    spec.option.timestep = TIME_STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for joint in spec.joints:  # MuJoCo keeps the URDF's effort limits
        joint.armature = ROTOR_INERTIA
        joint.frictionloss = JOINT_FRICTION
        motor = spec.add_actuator(name=joint.name, target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.gainprm[0] = 1.0
    return spec


class Scene:
    """A true arm above a table: a peg and a hole of a diameter [m], or a pen and paper."""

    def __init__(self, arm: Robot, hole: float | None = None) -> None:
        spec = _spec_of(arm)
        add_visuals(spec, arm)
        top = [0.55, 0, TABLE - 0.01]
        pale = [0.55, 0.6, 0.65, 1]
        _geom(
            spec.worldbody,
            "box",
            [0.45, 0.6, 0.01],
            pos=top,
            rgba=pale,
        )
        tool = spec.body(arm.tip)
        if hole is None:  # a pen is fixed like a peg; its tip is one sphere
            add_stem(tool, -4 * PEG_FILLET)
            _bead(tool, [0, 0, -PEG_FILLET], PEN_TOUCH)
        else:
            _add_peg(tool)
            _add_hole(spec, hole)
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self._tool: int = self.model.body(arm.tip).id

    def reset(self, q: np.ndarray) -> None:
        """Put the arm at rest at joint positions, shape (m,) [rad]; the hole stays."""
        hole = self.data.mocap_pos.copy()
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = q
        self.data.mocap_pos[:] = hole
        mujoco.mj_forward(self.model, self.data)

    def place_hole(self, centre: np.ndarray) -> None:
        """Stand the block with the hole somewhere on the table, shape (2,) [m]."""
        self.data.mocap_pos[0] = [*centre, TABLE]

    def show(self, q: np.ndarray) -> None:
        """Put the arm at joint positions, for a picture only."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)

    def step(self, torque: np.ndarray) -> None:
        """Let the joints exert torques, shape (m,) [N m], for one time step."""
        self.data.ctrl[:] = torque
        mujoco.mj_step(self.model, self.data)

    @property
    def tip(self) -> np.ndarray:
        """True position of the peg's or pen's tip, shape (3,) [m]."""
        return self.data.xpos[self._tool].copy()

    def contact_force(self) -> np.ndarray:
        """Return the force of block, table or paper on the tool, shape (3,) [N]."""
        mujoco.mj_rnePostConstraint(self.model, self.data)
        return self.data.cfrc_ext[self._tool, 3:].copy()


def _add_peg(body: Any) -> None:
    """Fix a peg along the ball link's z axis, the middle of its end where the ball's centre was."""
    # A capsule is its side, and a ring of spheres the rounded edge of its flat end: shapes whose
    # contacts MuJoCo computes exactly.
    add_stem(body, 0.0)
    side = [0, 0, -PEG_LENGTH, 0, 0, -PEG_RADIUS]
    _geom(
        body,
        "capsule",
        [PEG_RADIUS],
        fromto=side,
        group=HIDDEN,
        **PEG_TOUCH,
    )
    for angle in ANGLES:
        edge = (PEG_RADIUS - PEG_FILLET) * horizontal(angle)
        _bead(body, edge - [0, 0, PEG_FILLET], PEG_TOUCH)


def _bead(body: Any, place: ArrayLike, touch: dict[str, Any]) -> None:
    _geom(
        body,
        "sphere",
        [PEG_FILLET],
        pos=place,
        rgba=ORANGE,
        **touch,
    )


def _add_hole(spec: Any, diameter: float) -> None:
    """Stand boxes in a ring, so that a circle of the diameter fits between them."""
    # They overlap and are not shown; what is shown in their place is cut open.
    block = spec.worldbody.add_body(name="block", mocap=True)
    radius = diameter / 2
    rim = radius + HOLE_WALL
    half_depth = HOLE_DEPTH / 2
    size = [HOLE_WALL / 2, rim * np.tan(np.pi / HOLE_SIDES), half_depth]
    out = radius + HOLE_WALL / 2
    for angle in ANGLES:
        place = out * horizontal(angle) + [0, 0, half_depth]
        _geom(
            block,
            "box",
            size,
            pos=place,
            quat=_about_z(angle),
            group=HIDDEN,
        )
    add_open_block(spec, block, radius, rim)

"""The arm as it truly is, its tool, and what it touches, in MuJoCo."""

# MuJoCo's types are partial.
# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportAttributeAccessIssue=false

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...solver.urdf import Chain
from ...solver.urdf_text import set_origins

__all__ = ["HOLE_DEPTH", "JOINT_FRICTION", "PEG_RADIUS", "Scene", "urdf_of"]

Vector = NDArray[np.float64]
TIME_STEP = 1e-3
"""Of the physics, and of the controller [s]."""
JOINT_FRICTION = 0.4
"""Coulomb friction of each joint [N m]: within what was identified on such arms."""
ROTOR_INERTIA = 0.1
"""Of each motor, as the joint feels it through the gear [kg m^2]."""
PEG_RADIUS = 5e-3
PEG_FILLET = 1e-3
"""Rounding of the peg's edge [m]."""
PEG_LENGTH = 0.04
HOLE_DEPTH = 0.02
HOLE_SIDES = 24
HOLE_WALL = 0.06
"""From the hole's edge to the rim of the block around it [m]."""
CONTACT_FRICTION = 0.3
"""Plastic on plastic."""


def urdf_of(chain: Chain) -> bytes:
    """Return a chain's model with the origins that its joints have now."""
    return set_origins(chain.text, {joint.name: joint.origin for joint in chain.joints})


class Scene:
    """A simulated arm with a peg or a pen at its ball, above a table.

    Args:
        arm: With its true kinematics.
        table: Height of the table [m].
        hole: Diameter of the hole in the block on the table [m]; None for a pen on paper.
        friction: Coulomb friction of each joint [N m].
    """

    def __init__(
        self, arm: Chain, *, table: float, hole: float | None = None, friction: float = JOINT_FRICTION
    ) -> None:
        spec = mujoco.MjSpec.from_string(urdf_of(arm).decode())
        spec.compiler.fusestatic = False
        spec.option.timestep = TIME_STEP
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        _add_motors(spec, friction)
        _add_looks(spec, arm)
        _add_tool(spec.body(arm.tip), peg=hole is not None)
        _add_table(spec, table)
        if hole is not None:
            _add_hole(spec, hole)
        self.table = table
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self._tool: int = self.model.body(arm.tip).id

    def reset(self, q: Vector) -> None:
        """Put the arm at rest at joint positions, shape (m,) [rad]; the hole stays."""
        hole = self.data.mocap_pos.copy()
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = q
        self.data.mocap_pos[:] = hole
        mujoco.mj_forward(self.model, self.data)

    def place_hole(self, centre: Vector) -> None:
        """Stand the block with the hole somewhere on the table, shape (2,) [m]."""
        self.data.mocap_pos[0] = [*centre, self.table]

    def step(self, torque: Vector) -> None:
        """Let the joints exert torques, shape (m,) [N m], for one time step."""
        self.data.ctrl[:] = torque
        mujoco.mj_step(self.model, self.data)

    @property
    def tip(self) -> Vector:
        """Where the peg's or pen's tip truly is, shape (3,) [m]."""
        return self.data.xpos[self._tool].copy()

    def contact_force(self) -> Vector:
        """Return the force of block, table or paper on the tool, shape (3,) [N]."""
        mujoco.mj_rnePostConstraint(self.model, self.data)
        return self.data.cfrc_ext[self._tool, 3:].copy()


def _add_motors(spec: Any, friction: float) -> None:
    """Give each joint a motor, its inertia, and friction; MuJoCo keeps the URDF's effort limits."""
    for joint in spec.joints:
        joint.armature = ROTOR_INERTIA
        joint.frictionloss = friction
        motor = spec.add_actuator(name=joint.name, target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.gainprm[0] = 1.0


def _add_looks(spec: Any, arm: Chain) -> None:
    """Draw a capsule from each joint to the next, and a drum on each joint; they touch nothing."""
    for joint, following in zip(arm.joints, arm.joints[1:], strict=False):
        body = spec.body(joint.child)
        end = np.array(following.origin.xyz)
        if joint.actuated:
            _ghost(body, mujoco.mjtGeom.mjGEOM_CYLINDER, [0.055, 0.06, 0], [0.25, 0.28, 0.32, 1])
        if np.linalg.norm(end) > 0.02:
            link = _ghost(body, mujoco.mjtGeom.mjGEOM_CAPSULE, [0.04, 0, 0], [0.9, 0.9, 0.92, 1])
            link.fromto = [0, 0, 0, *end]


def _ghost(body: Any, shape: Any, size: list[float], colour: list[float]) -> Any:
    return body.add_geom(type=shape, size=size, rgba=colour, contype=0, conaffinity=0, mass=0)


def _add_tool(body: Any, *, peg: bool) -> None:
    """Fix a tool along the ball link's z axis, the tip where the ball's centre was.

    A peg is a capsule for its side, and a ring of spheres for the rounded edge of its flat end:
    shapes whose contacts MuJoCo computes exactly. A pen is one sphere.
    """
    touch = {"friction": [CONTACT_FRICTION, 0, 0], "solref": [2 * TIME_STEP, 1], "mass": 0}
    colour = [0.85, 0.3, 0.1, 1]
    stem = _ghost(body, mujoco.mjtGeom.mjGEOM_CYLINDER, [PEG_RADIUS, 0, 0], colour)
    stem.fromto = [0, 0, -PEG_LENGTH, 0, 0, 0 if peg else -4 * PEG_FILLET]
    if peg:
        side = [0, 0, -PEG_LENGTH, 0, 0, -PEG_RADIUS]
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[PEG_RADIUS, 0, 0],
            fromto=side,
            group=3,
            **touch,
        )
    count, ring = (HOLE_SIDES, PEG_RADIUS - PEG_FILLET) if peg else (1, 0.0)
    for angle in np.arange(count) * 2 * np.pi / count:
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[PEG_FILLET, 0, 0],
            pos=[ring * np.cos(angle), ring * np.sin(angle), -PEG_FILLET],
            rgba=colour,
            **touch,
        )


def _add_table(spec: Any, height: float) -> None:
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.45, 0.6, 0.01],
        pos=[0.55, 0, height - 0.01],
        rgba=[0.55, 0.6, 0.65, 1],
        friction=[CONTACT_FRICTION, 0, 0],
    )
    spec.worldbody.add_light(pos=[0.3, -1.0, 2.0], dir=[0.1, 0.5, -1.0])


def _add_hole(spec: Any, diameter: float) -> None:
    """Stand boxes in a ring, so that a circle of the diameter fits between them."""
    block = spec.worldbody.add_body(name="block", mocap=True)
    radius = diameter / 2
    half_width = (radius + HOLE_WALL) * np.tan(np.pi / HOLE_SIDES)
    for angle in np.arange(HOLE_SIDES) * 2 * np.pi / HOLE_SIDES:
        out = radius + HOLE_WALL / 2
        block.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[HOLE_WALL / 2, half_width, HOLE_DEPTH / 2],
            pos=[out * np.cos(angle), out * np.sin(angle), HOLE_DEPTH / 2],
            quat=[np.cos(angle / 2), 0, 0, np.sin(angle / 2)],
            rgba=[0.3, 0.5, 0.7, 1],
            friction=[CONTACT_FRICTION, 0, 0],
        )

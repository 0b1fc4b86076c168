"""Visual shapes of the scene: nothing here is touched or weighs anything."""

from typing import Any

import mujoco
import numpy as np

from ...solver.robot import Robot

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
    sky, gradient = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    pale = {"rgb1": [0.97, 0.98, 0.99], "rgb2": [0.85, 0.88, 0.91]}
    spec.add_texture(name="sky", type=sky, builtin=gradient, width=64, height=384, **pale)
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.quality.shadowsize = SHADOW
    spec.worldbody.add_light(pos=[0.3, -1.0, 2.0], dir=[0.1, 0.5, -1.0])
    ends = np.array([joint.origin.xyz for joint in arm.joints[1:]])
    lengths = np.linalg.norm(ends, axis=1)
    to_tip = np.cumsum(lengths[::-1])[::-1] - lengths
    shown = np.clip(1 - (TOOL - to_tip) / np.maximum(lengths, 1e-9), 0, 1)
    for joint, end, length in zip(arm.joints, ends * shown[:, None], lengths * shown, strict=False):
        body = spec.body(joint.child)
        if joint.actuated:
            _ghost(body, type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.055, 0.06, 0], rgba=DARK)
        if length > 0.02:
            line = [0, 0, 0, *end]
            capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
            _ghost(body, type=capsule, size=[0.04, 0, 0], fromto=line, rgba=LIGHT)


def add_stem(body: Any, radius: float, ends: list[float]) -> None:
    """Add a peg's or pen's cylinder between two heights on the z axis [m]."""
    line = [0, 0, ends[0], 0, 0, ends[1]]
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    _ghost(body, type=cylinder, size=[radius, 0, 0], fromto=line, rgba=ORANGE)


def add_open_block(spec: Any, body: Any, radii: tuple[float, float], height: float) -> None:
    """Add a block with a hole, of two radii and a height [m], cut open so that the peg is seen."""
    inner, outer = radii
    profile = [(inner, 0.0), (outer, 0.0), (outer, height), (inner, height)]
    turn = np.deg2rad(OPEN_TO + CUT / 2 + (360 - CUT) * np.arange(SLICES + 1) / SLICES)
    corners = [[r * np.cos(a), r * np.sin(a), z] for a in turn for r, z in profile]
    quads = [
        (4 * k + i, 4 * k + 4 + i, 4 * k + 4 + (i + 1) % 4, 4 * k + (i + 1) % 4)
        for k in range(SLICES)
        for i in range(4)
    ]
    last = 4 * SLICES
    quads += [(0, 1, 2, 3), (last + 3, last + 2, last + 1, last)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    spec.add_mesh(
        name="block", uservert=np.ravel(corners), userface=np.ravel(faces), smoothnormal=0
    )
    _ghost(body, type=mujoco.mjtGeom.mjGEOM_MESH, meshname="block", rgba=BLUE)


def _ghost(body: Any, **shape: Any) -> None:
    body.add_geom(contype=0, conaffinity=0, mass=0, **shape)

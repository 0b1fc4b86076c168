"""A layer over a USD model of one's own: usd-core composes it, and its joints give the ball.

A joint of UsdPhysics holds a frame of each of its bodies; they coincide at zero, and the second
body turns about or slides along the joint's axis.
"""

import numpy as np
import pytest
from imagined import configurations, rigid

from mukca import load_calibration, load_robot
from mukca.solver.identification.data import kabsch

pytest.importorskip("pxr", reason="the extra usd is not installed")
from pxr import Gf, Usd, UsdGeom, UsdPhysics

ON_STAND = rigid((0.4, -0.2, 0.8, 0.2, -0.3, 2.0))
SINGLE = 1e-7
"""What single precision leaves of a chain of a metre [m]."""
TOOL = rigid((0.01, 0.0, 0.05, 0.2, 0.0, 0.1))


def frames(robot, seed=0):
    """Where each URDF link, the base's first, stands in its body: anywhere."""
    rng = np.random.default_rng(seed)
    return [rigid(rng.uniform(-0.3, 0.3, 6)) for _ in range(len(robot.actuated) + 1)]


def matrix(T, unit):
    T = T.copy()
    T[:3, 3] /= unit
    return Gf.Matrix4d(T.T.tolist())


def onto_z(axis):
    """A turn, (4, 4), whose z axis is another."""
    rotation = Gf.Rotation(Gf.Vec3d(0, 0, 1), Gf.Vec3d(*axis))
    T = np.eye(4)
    T[:3, :3] = np.array(Gf.Matrix3d(rotation)).T
    return T


def frame(T, unit):
    """A place and a turn as a joint has them."""
    turn = Gf.Matrix3d(T[:3, :3].T.tolist()).ExtractRotation().GetQuat()
    return Gf.Vec3f(*(T[:3, 3] / unit).tolist()), Gf.Quatf(turn)


def add_joint(stage, kind, name, bodies, places, unit):
    joint = kind.Define(stage, f"/arm/joints/{name}")
    joint.CreateBody0Rel().SetTargets([bodies[0]] if bodies[0] else [])
    joint.CreateBody1Rel().SetTargets([bodies[1]])
    for side, T in enumerate(places):
        place, turn = frame(T, unit)
        getattr(joint, f"CreateLocalPos{side}Attr")(place)
        getattr(joint, f"CreateLocalRot{side}Attr")(turn)
    return joint


def add_body(stage, path, world, unit, parent):
    shape = UsdGeom.Xform.Define(stage, path)
    shape.AddTransformOp().Set(matrix(np.linalg.inv(parent) @ world, unit))
    UsdPhysics.RigidBodyAPI.Apply(shape.GetPrim())
    return shape


def model_of(robot, file, q, unit=1.0, nested=False):
    """Write a model of the nominal arm as an importer may have, standing at joint positions."""
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/arm").GetPrim())
    links, path, positions = frames(robot), "/arm/base", iter(q)
    body = ON_STAND @ np.linalg.inv(links[0])
    add_body(stage, path, body, unit, np.eye(4))
    add_joint(stage, UsdPhysics.FixedJoint, "stand", ("", path), (body, np.eye(4)), unit)
    place, count = links[0], 0
    for joint in robot.joints:
        place = place @ rigid(joint.origin.numbers)
        if not joint.actuated:
            continue
        count += 1
        below = f"{path if nested else '/arm'}/link{count}"
        upright = onto_z(joint.axis)
        ends = place @ upright, links[count] @ upright
        kinds = {"prismatic": UsdPhysics.PrismaticJoint}
        kind = kinds.get(joint.type, UsdPhysics.RevoluteJoint)
        add_joint(stage, kind, joint.name, (path, below), ends, unit).CreateAxisAttr("Z")
        turn = moved(joint.type, next(positions))
        new = body @ ends[0] @ turn @ np.linalg.inv(ends[1])
        add_body(stage, below, new, unit, body if nested else np.eye(4))
        path, body, place = below, new, links[count]
    add_body(stage, "/arm/hand", body @ TOOL, unit, np.eye(4))
    fixed = (path, "/arm/hand")
    add_joint(stage, UsdPhysics.FixedJoint, "hand", fixed, (TOOL, np.eye(4)), unit)
    stage.GetRootLayer().Save()


def moved(kind, q):
    """The motion of a joint along or about z."""
    return rigid((0, 0, q, 0, 0, 0) if kind == "prismatic" else (0, 0, 0, 0, 0, q))


class Model:
    """What usd-core composes of a file."""

    def __init__(self, file):
        self.stage = Usd.Stage.Open(str(file))
        self.unit = UsdGeom.GetStageMetersPerUnit(self.stage)

    def world(self, path):
        T = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(self.stage.GetPrimAtPath(path)))
        return self._metres(T.T)

    def _metres(self, T):
        T[:3, 3] *= self.unit
        return T

    def _frame(self, prim, side):
        turn = Gf.Quatd(prim.GetAttribute(f"physics:localRot{side}").Get()).GetNormalized()
        T = np.eye(4)
        T[:3, :3] = np.array(Gf.Matrix3d(Gf.Rotation(turn))).T
        T[:3, 3] = prim.GetAttribute(f"physics:localPos{side}").Get()
        return self._metres(T)

    def ends(self, robot, q):
        """The poses of the bodies in the base at joint positions, by path."""
        T, poses = np.eye(4), {}
        for joint, angle in zip(robot.actuated, q, strict=True):
            prim = self.stage.GetPrimAtPath(f"/arm/joints/{joint.name}")
            turn = moved(joint.type, angle)
            T = T @ self._frame(prim, 0) @ turn @ np.linalg.inv(self._frame(prim, 1))
            poses[str(prim.GetRelationship("physics:body1").GetTargets()[0])] = T
        return poses


@pytest.fixture(params=["panda", "ur5e"])
def arm(request, calibrations):
    file = calibrations / f"{request.param}.json"
    return file, load_calibration(file)


@pytest.mark.parametrize(("unit", "nested"), [(1.0, False), (0.01, True)])
def test_the_ball_is_the_calibrated_arms(export, arm, tmp_path, unit, nested):
    file, calibration = arm
    robot = calibration.robot
    mine, out = tmp_path / "models" / "arm.usda", tmp_path / "out" / "calibrated.usda"
    mine.parent.mkdir()
    out.parent.mkdir()
    stand = configurations(robot, 1, seed=3)[0]
    model_of(robot, mine, stand, unit, nested)
    kept = mine.read_bytes()
    status, shown, error = export(file, "--to", "usd", "--like", mine, "--out", out)
    assert status == 0 and "single precision" in shown, error
    assert mine.read_bytes() == kept
    before, after = Model(mine), Model(out)
    assert after.unit == unit and str(after.stage.GetDefaultPrim().GetPath()) == "/arm"
    q = configurations(robot, 10)
    last = [*after.ends(robot, q[0])][-1]
    mark = np.linalg.inv(after.world(last)) @ after.world(f"{last}/mukca_ball")
    found = np.array([(after.ends(robot, row)[last] @ mark)[:3, 3] for row in q])
    # the model's base is the URDF's but for a motion that is the same everywhere
    expected = calibration.calibrated.geometric_ball(q)
    assert apart(found, expected) < SINGLE
    old = np.array([(before.ends(robot, row)[last] @ mark)[:3, 3] for row in q])
    assert apart(old, expected) > 1e-4
    # bodies stand at the angles at which they stood, and the hand on the last of them
    assert np.abs(after.world("/arm/base") - before.world("/arm/base")).max() == 0
    for path, T in after.ends(robot, stand).items():
        assert np.abs(after.world("/arm/base") @ T - after.world(path)).max() < 3 * SINGLE
    hands = [np.linalg.inv(m.world(last)) @ m.world("/arm/hand") for m in (before, after)]
    assert np.abs(hands[0] - hands[1]).max() < 1e-9


def apart(points, others):
    """The largest distance of points from others after the best rigid motion [m]."""
    return np.abs(kabsch(points, others).apply(points) - others).max()


def scaled(stage):
    UsdGeom.Xformable(stage.GetPrimAtPath("/arm/link3")).AddScaleOp().Set((2, 2, 2))


def apart_from_the_one_before(stage):
    joint = stage.GetPrimAtPath("/arm/joints/panda_joint3")
    joint.GetRelationship("physics:body0").SetTargets(["/arm/base"])


def called_otherwise(stage):
    stage.RemovePrim("/arm/joints/panda_joint3")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (scaled, "/arm/link3 is scaled"),
        (apart_from_the_one_before, "body0 of 'panda_joint3' is not body1 of 'panda_joint2'"),
        (called_otherwise, "it lacks panda_joint3"),
    ],
)
def test_a_model_that_is_no_such_chain_is_refused(refused, calibrations, tmp_path, change, says):
    mine, words = tmp_path / "arm.usda", (calibrations / "panda.json", "--to", "usd", "--like")
    model_of(load_robot("panda"), mine, np.zeros(7))
    stage = Usd.Stage.Open(str(mine))
    change(stage)
    stage.GetRootLayer().Save()
    refused(says, "export", *words, mine, "--out", tmp_path / "new.usda")


def test_what_is_no_model_of_the_arm_is_refused(refused, calibrations, tmp_path):
    mine, words = tmp_path / "arm.usda", ("--to", "usd", "--out", tmp_path / "new.usda")
    panda, ur5e = calibrations / "panda.json", calibrations / "ur5e.json"
    refused("needs --like FILE", "export", panda, *words)
    refused("is no file", "export", panda, *words, "--like", mine)
    mine.write_text("#usda 1.0\n(((")
    refused("USD cannot read it", "export", panda, *words, "--like", mine)
    model_of(load_robot("ur10e"), tmp_path / "other.usda", np.zeros(6))
    refused("another arm's model", "export", ur5e, *words, "--like", tmp_path / "other.usda")
    refused("ends in .usda", "export", panda, *words[:-1], tmp_path / "new.usd")

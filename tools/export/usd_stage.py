"""The user's own USD model: the arm's joints in it, and an empty layer over it."""

import os
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .mjcf_joints import match_joints
from .request import ExportError, Request

METADATA = (
    "defaultPrim",
    "kilogramsPerUnit",
    "metersPerUnit",
    "timeCodesPerSecond",
    "upAxis",
)
"""A stage takes these from its topmost layer alone."""
_SIDES = (0, 1)
RIGID = 1e-5
"""A body's axes may be so far from a rotation; more is a scale."""


class UsdJoint(NamedTuple):
    """A joint of UsdPhysics between two bodies: its frame on each, shape (4, 4) [m]."""

    prim: Any
    bodies: tuple[str, str]
    """Paths; empty for the world."""
    frames: tuple[np.ndarray, np.ndarray]

    @property
    def axis(self) -> np.ndarray:
        """Its axis in its frame, shape (3,)."""
        axes: np.ndarray = np.eye(3)
        return axes["XYZ".index(self.prim.GetAttribute("physics:axis").Get() or "X")]


class UsdStage:
    """The model under a layer that takes all changes; lengths in metres.

    Raises:
        ExportError: usd-core is not installed, or the model cannot be read.
    """

    def __init__(self, request: Request) -> None:
        try:
            from pxr import Sdf, Usd, UsdGeom, UsdPhysics
        except ImportError:
            raise ExportError(
                "usd-core is not installed; install the extra: pip install 'mukca[usd]'"
            ) from None
        if not request.like or not request.like.is_file():
            raise ExportError(
                f"--to usd needs --like FILE, your own USD model; {request.like} is no file"
            )
        try:
            source = Sdf.Layer.FindOrOpen(str(request.like.resolve()))
        except RuntimeError as error:
            reason = " ".join(str(error).split()).rpartition(" : ")[2]
            raise ExportError(
                f"--like {request.like}: USD cannot read it: {reason}"
            ) from None
        self.like = request.like
        self.layer = Sdf.Layer.CreateAnonymous(".usda")
        for key in METADATA:
            if source.pseudoRoot.HasInfo(key):
                self.layer.pseudoRoot.SetInfo(key, source.pseudoRoot.GetInfo(key))
        self.layer.subLayerPaths.append(source.identifier)
        self.stage = Usd.Stage.Open(self.layer)
        self.unit: float = UsdGeom.GetStageMetersPerUnit(self.stage)
        self.joints = [
            self._joint(prim)
            for prim in self.stage.Traverse()
            if prim.IsA(UsdPhysics.Joint)
        ]

    def arm(self, request: Request) -> list[UsdJoint]:
        """Return the joints of the arm, in its order, each on the body of the one before."""
        kinds = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint")
        moving = [j for j in self.joints if j.prim.GetTypeName() in kinds]
        names = [joint.prim.GetName() for joint in moving]
        joints = [moving[i] for i in match_joints(names, request)]
        for before, joint in pairwise(joints):
            if joint.bodies[0] != before.bodies[1]:
                raise ExportError(
                    f"{self.like}: body0 of {joint.prim.GetName()!r} is not body1 of "
                    f"{before.prim.GetName()!r}, the joint before it in the URDF's chain"
                )
        return joints

    def world_pose(self, path: str) -> np.ndarray:
        """Return the pose of a body in the world, shape (4, 4); refuse one with a scale."""
        from pxr import UsdGeom

        if not path:
            return np.eye(4)
        prim = self.stage.GetPrimAtPath(path)
        T = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim)).T
        R = T[:3, :3]
        if np.abs(R @ R.T - np.eye(3)).max() > RIGID:
            raise ExportError(
                f"{self.like}: {path} is scaled; give the scale to its shapes"
            )
        T[:3, 3] *= self.unit
        return T

    def place(self, path: str, world: np.ndarray) -> None:
        """Put a body, or a new frame, at a pose in the world, shape (4, 4)."""
        from pxr import Gf, UsdGeom

        prim = self.stage.GetPrimAtPath(path) or self.stage.DefinePrim(path, "Xform")
        shape = UsdGeom.Xformable(prim)
        apart = shape.GetResetXformStack()
        above = np.eye(4)
        if not apart:
            above = self.world_pose(str(prim.GetParent().GetPath()).rstrip("/"))
        local = np.linalg.inv(above) @ world
        local[:3, 3] /= self.unit
        shape.MakeMatrixXform().Set(Gf.Matrix4d(local.T.tolist()))
        shape.SetResetXformStack(apart)

    def set_frame(self, joint: UsdJoint, frame: np.ndarray) -> np.ndarray:
        """Set a joint's frame on its first body; return it as single precision keeps it."""
        from pxr import Gf

        matrix = Gf.Matrix3d(frame[:3, :3].T.tolist())
        place = (frame[:3, 3] / self.unit).tolist()
        turn = Gf.Quatf(matrix.ExtractRotation().GetQuat())
        joint.prim.GetAttribute("physics:localPos0").Set(Gf.Vec3f(*place))
        joint.prim.GetAttribute("physics:localRot0").Set(turn)
        return self._frame(joint.prim, 0)

    def _joint(self, prim: Any) -> UsdJoint:
        first, second = (
            "".join(map(str, prim.GetRelationship(f"physics:body{i}").GetTargets()))
            for i in _SIDES
        )
        frames = self._frame(prim, 0), self._frame(prim, 1)
        return UsdJoint(prim, (first, second), frames)

    def _frame(self, prim: Any, side: int) -> np.ndarray:
        """Return a joint's frame on one of its bodies, shape (4, 4)."""
        from pxr import Gf

        T = np.eye(4)
        place = prim.GetAttribute(f"physics:localPos{side}").Get()
        turn = Gf.Quatd(prim.GetAttribute(f"physics:localRot{side}").Get())
        T[:3, :3] = np.array(Gf.Matrix3d(Gf.Rotation(turn.GetNormalized()))).T
        T[:3, 3] = self.unit * np.array(place, dtype=float)
        return T

    def text(
        self,
        folder: Path,
        about: str,
    ) -> bytes:
        """Return the layer's text, which finds the model from a folder."""
        del self.stage
        self.layer.customLayerData = {"mukca": about}
        path = os.path.relpath(self.like.resolve(), folder.resolve())
        self.layer.subLayerPaths[0] = Path(path).as_posix()
        return self.layer.ExportToString().encode()

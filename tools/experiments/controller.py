"""Cartesian impedance control with an offset compensator: Eqs. (6) to (8) and Table II.

    M(q) ddq + C(q, dq) dq + g(q) = tau_c + tau_comp + tau_ext                   (6)
    tau_c    = J' (K (x_goal - Phi(q)) - D J dq) + C dq + g                      (7)
    tau_comp = J' integral of K (x_goal - Phi(q)) dt, over 5 s                   (8)

Phi, J, C and g are those of the model that the controller is given; the arm moves by its true ones.
"""

from typing import Any

import numpy as np
import pinocchio as pin

from ...solver.identification.robot import ModelError

Pose = Any
"""A ``pinocchio.SE3``: the tool's pose in the base frame."""


STIFFNESS = np.array([15000.0, 15000.0, 2000.0, 40.0, 40.0, 40.0])
"""K of Table II, along x, y, z and about them, in the base frame [N/m, N m/rad]."""
DAMPING = 2 * np.sqrt(STIFFNESS)
"""D [N s/m, N m s/rad]."""
WINDOW = 5.0
"""Time over which the compensator integrates, Delta t [s]."""


class ArmModel:
    """An arm as one URDF describes it; what a controller knows of it."""

    def __init__(self, urdf: bytes, joint_names: tuple[str, ...], tip: str) -> None:
        try:
            self.model: Any = pin.buildModelFromXML(urdf.decode())
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"not a model that Pinocchio reads: {error}") from None
        _, *names = self.model.names  # the first is the universe
        if names != [*joint_names]:
            there, wanted = ", ".join(names), ", ".join(joint_names)
            raise ModelError(f"its joints are {there}; the arm's are {wanted}")
        if not self.model.existFrame(tip):
            raise ModelError(f"it has no link {tip!r}")
        self.data: Any = self.model.createData()
        self.tip: int = self.model.getFrameId(tip)

    def pose(self, q: np.ndarray) -> Pose:
        """Return the tool's pose Phi(q) in the base frame."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.tip].copy()

    def linearise(self, q: np.ndarray) -> tuple[Pose, np.ndarray]:
        """Return Phi(q), which the next call overwrites, and J(q), shape (6, m), base frame."""
        pin.computeJointJacobians(self.model, self.data, q)
        pose = pin.updateFramePlacement(self.model, self.data, self.tip)
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pose, pin.getFrameJacobian(self.model, self.data, self.tip, frame)

    def bias(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Return C(q, dq) dq + g(q), shape (m,) [N m]."""
        return pin.nonLinearEffects(self.model, self.data, q, dq)


def pose_error(goal: Pose, pose: Pose) -> np.ndarray:
    """Return x_goal - Phi in the base frame, shape (6,): translation, rotation vector [m, rad]."""
    # With equal stiffness k about all axes the rotation's torque is then the gradient of the
    # energy k |rotation|^2 / 2.
    translation = goal.translation - pose.translation
    rotation = pin.log3(goal.rotation @ pose.rotation.T)
    return np.concatenate([translation, rotation])


class ImpedanceController:
    """Eq. (7), and Eq. (8) while it is asked for."""

    def __init__(self, model: ArmModel) -> None:
        self.model = model
        self.offset: np.ndarray = np.zeros(6)
        """The compensator's force and torque at the tool: the integral in Eq. (8)."""

    def torque(
        self,
        goal: Pose,
        q: np.ndarray,
        dq: np.ndarray,
        dt: float,
        *,
        compensate: bool,
    ) -> np.ndarray:
        """Return tau_c + tau_comp, shape (m,) [N m], in a step of dt [s]; the latter may be off."""
        pose, J = self.model.linearise(q)
        spring = STIFFNESS * pose_error(goal, pose)
        damper = DAMPING * (J @ dq)
        self.offset = self.offset + spring * dt if compensate else np.zeros(6)
        wrench = spring - damper + self.offset
        return J.T @ wrench + self.model.bias(q, dq)

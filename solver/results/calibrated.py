"""A calibrated robot: where its ball truly is, and the URDF that says so."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..identification.data import STANDARD_LOAD, Load, Measurement, TipSamples
from ..identification.model import Deflection
from ..identification.robot import (
    BallModel,
    Origin,
    Parameter,
    Robot,
    RotationNumbers,
    choose_parameters,
    scan,
    set_origins,
    urdf_of,
)
from .by_model import ModelName
from .files import relocate_meshes
from .joint_rows import effort_rows, position_rows, rows_for_poses

Payload = tuple[float, Sequence[float]]
"""Mass [kg], and its centre in the flange's frame [m]."""
AT_LIMIT = 1e-9
"""A joint this near to its limit stands at it [rad, m]."""


@dataclass(frozen=True, repr=False)
class CalibratedRobot:
    """A robot with calibrated joint origins and, where the data support it, joint deflections.

    It predicts the ball's centre as Phi(Theta, q'): the forward kinematics Phi with the calibrated
    origins Theta, at joint positions q' that are corrected for elasticity and transmission error,
    see :class:`.Deflection`.
    """

    robot: Robot
    """The nominal robot."""
    parameters: tuple[Parameter, ...] = ()
    """Calibrated numbers of its geometry."""
    values: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """The calibrated parameters, shape (n,) [m, rad]."""
    deflection: Deflection = field(default_factory=Deflection)
    """Elasticity and transmission error, by which joint positions are corrected first."""
    load: Load = STANDARD_LOAD
    """Gravity and payload, for joint torques where no effort is measured."""
    exported: np.ndarray | None = None
    """The best parameters for a program that does not correct joint positions, such as one that
    reads a URDF alone, shape (n,) [m, rad]. None: nothing is to be corrected, so :attr:`values`."""
    rotation_numbers: RotationNumbers = "vector"
    """Kind of the parameters of a joint's rotation."""

    def __getstate__(self) -> dict[str, Any]:
        """Go to other processes without what was compiled here."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def model(self) -> BallModel:
        """The ball's position as a function of :attr:`parameters` and joint positions."""
        return BallModel(
            self.robot, [p.index for p in self.parameters], self.rotation_numbers
        )

    def carrying(self, payload: Payload | None) -> "CalibratedRobot":
        """Return the robot that carries a payload; None for the load of the recordings."""
        if payload is None:
            return self
        robot = self.robot.carrying(*payload)
        return replace(self, robot=robot, load=Load(self.load.gravity, 0.0))

    @property
    def flange(self) -> int:
        """Index of the chain's joint whose child link carries the ball."""
        return len(self.robot.joints) - 2

    def starts(self, q: ArrayLike | None, count: int, what: str) -> np.ndarray:
        """Return one row of joint positions for each pose; the middle of the ranges for none."""
        start = self.middle if q is None else q
        return rows_for_poses(self.robot, start, count, what)

    @property
    def middle(self) -> np.ndarray:
        """The middle of the joints' ranges, zero for those without end, shape (m,) [rad]."""
        lower, upper = self.robot.lower, self.robot.upper
        return np.where(np.isfinite(upper - lower), (lower + upper) / 2, 0.0)

    def stopped(self, q: np.ndarray) -> str:
        """Return the joint that stands at its limit, empty for none."""
        below = q < self.robot.lower + AT_LIMIT
        above = q > self.robot.upper - AT_LIMIT
        return next(compress(self.robot.joint_names, below | above), "")

    @property
    def geometry(self) -> np.ndarray:
        """The best :attr:`values` for programs that do not correct joint positions, shape (n,)."""
        return self.values if self.exported is None else self.exported

    @cached_property
    def nominal(self) -> "CalibratedRobot":
        """The robot by its nominal URDF."""
        return self._rigid(self.model.nominal)

    @property
    def with_ball_alone(self) -> "CalibratedRobot":
        """The robot by its nominal URDF, but for the ball's place on the flange."""
        of_ball = np.array([p.of_ball for p in self.parameters], dtype=bool)
        return self._rigid(np.where(of_ball, self.geometry, self.model.nominal))

    @cached_property
    def geometric(self) -> "CalibratedRobot":
        """The robot by ``calibrated.urdf`` alone, without any correction of joint positions."""
        return self._rigid(self.geometry)

    def _rigid(self, values: np.ndarray) -> "CalibratedRobot":
        return replace(self, values=values, deflection=Deflection(), exported=None)

    @property
    def models(self) -> "dict[ModelName, CalibratedRobot]":
        """The models to compare: the exported geometry only where it differs from the full one."""
        by_name: dict[ModelName, CalibratedRobot] = {}
        if self.exported is not None:
            by_name["geometric"] = self.geometric
        return {"nominal": self.nominal, "calibrated": self, **by_name}

    @property
    def origins(self) -> np.ndarray:
        """Origins of all joints in ``calibrated.urdf``, shape (joints, 6) [m, rad]."""
        return self.model.origins(self.geometry)

    def ball(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return the ball's centre in the base frame [m].

        Args:
            q: Joint positions in chain order, shape (m,) or (N, m) [rad].
            effort: What the joints exert on the arm, of the same shape [N m]; None for the
                gravity torques of the model's masses.

        Returns:
            Shape (3,) or (N, 3).

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
        """
        points = self.model.points(self.values, self._corrected(q, effort))
        return points.reshape(*np.shape(q)[:-1], 3)

    def true_positions(
        self, q: ArrayLike, effort: ArrayLike | None = None
    ) -> np.ndarray:
        """Return where the joints truly are while their encoders read q, of q's shape [rad].

        Args and errors are those of :meth:`ball`. Tilts of the joints are no positions.
        """
        rows = self._corrected(q, effort)[:, : len(self.robot.joint_names)]
        return rows.reshape(np.shape(q))

    def _corrected_at(self, measured: Measurement) -> np.ndarray:
        """Return :meth:`_corrected` of samples, by their placement's own load."""
        if not self.deflection.extensions:
            return measured.positions
        return self.deflection.true_positions(self.load.samples(self.robot, measured))

    def _corrected(self, q: ArrayLike, effort: ArrayLike | None) -> np.ndarray:
        """Return the true joint positions, and the tilts where there are any."""
        positions = self.positions(q)
        efforts = None
        if effort is not None:
            efforts = effort_rows(self.robot, effort, len(positions))
        if not self.deflection.extensions:
            return positions
        samples = self.load.at(self.robot, positions, efforts)
        return self.deflection.true_positions(samples)

    def geometric_ball(self, q: ArrayLike) -> np.ndarray:
        """Return :meth:`ball` by the exported URDF alone, without any correction of q."""
        return self.geometric.ball(q)

    def nominal_ball(self, q: ArrayLike) -> np.ndarray:
        """Return :meth:`ball` by the nominal URDF."""
        return self.nominal.ball(q)

    def predict(self, measured: Measurement) -> np.ndarray:
        """Return the ball's centres at samples as if their place had not moved, shape (N, 3)."""
        points = self.model.points(self.values, self._corrected_at(measured))
        return measured.at_rest(points)

    def rotations(self, measured: Measurement) -> np.ndarray:
        """Return orientations of the ball's link at samples, shape (N, 3, 3)."""
        true = self._corrected_at(measured)
        return self.model.rotations(self.values, true).points

    def tips(self, measured: Measurement) -> TipSamples:
        """Return the balls and orientations of their link at points that were measured."""
        points, rotations = self.predict(measured), self.rotations(measured)
        return TipSamples(points, rotations, measured.points)

    def positions(
        self, q: ArrayLike, what: str = "joint positions", *, stacked: bool = False
    ) -> np.ndarray:
        """Return joint positions as rows, shape (N, m), checked as by :meth:`ball`.

        They have shape (m,) or (N, m), or if they may be ``stacked``, (..., m).
        """
        return position_rows(self.robot, q, what, stacked=stacked)

    def urdf(self, folder: Path | None = None) -> bytes:
        """Return the calibrated URDF: joint origins replaced, all else as it was.

        Relative mesh paths are rewritten to be found from the folder where it will stand, if any.
        """
        pairs = zip(self.robot.joints, self.origins.tolist(), strict=True)
        changed = {joint.name: Origin.of(numbers) for joint, numbers in pairs}
        text = set_origins(self.robot.text, changed)
        source = Path(urdf_of(self.robot.source))
        if folder is None or not source.is_file():
            return text
        return relocate_meshes(scan(text, self.robot.source), source.parent, folder)


Place = tuple[float, float, float]
"""Coordinates [m]."""


def ball_of(robot: Robot) -> tuple[Parameter, ...]:
    """Return the parameters that are the ball's place in its link."""
    return tuple(choose_parameters(robot, free=[f"{robot.ball_joint.name}.xyz"]))


def with_ball_at(robot: Robot, place: Place | None) -> CalibratedRobot | None:
    """Return the nominal robot with its ball at a place in its link [m]; None without one."""
    if place is None:
        return None
    return CalibratedRobot(robot, ball_of(robot), np.array(place))

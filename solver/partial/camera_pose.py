"""A camera on the arm or beside it, by a board's poses in it, the calibrated chain held.

With F(q) the flange and B_i the board's pose in the camera,

    on the arm   F(q_i) U B_i = V     U the camera on the flange, V the board in the base
    beside it    F(q_i) U = V B_i     U the board on the flange, V the camera in the base

An instrument that measures poses of what the flange carries is a camera beside the arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, Literal, get_args

import numpy as np

from ...recorder import Placement, distinct
from ..calibration import Calibration, UsageError, as_list, quaternion_of
from ..identification.data import HandEye, Pose, measure, one_blas_thread, order_said
from .doubts import changed_zeros, with_right_size
from .fit import fit
from .prior import ArmPrior, prior_of
from .readings import as_poses, fitting_order, fitting_reading
from .system import OUTLIER, System
from .task import FAR, NoiseBelief, Rows, Task
from .updated import LIMIT, Found, found, not_enough, signed

Camera = Literal["on-arm", "beside"]
Scale = Literal["board", "exact"]
DETECTOR = NoiseBelief(3e-4, turn=1e-3, spread=1.5)
"""Noise of a detector before its poses are seen."""
SIZE_UNTOLD = (
    "These views do not show the size of the board: vary its distance and turn it about two axes; "
    "the pose is by the size that was said."
)
FARTHEST = 50.0
"""Distance beyond which no camera sees a board [m]."""
REMEDY = "turn the flange about two axes, by 0.5 rad and more, between views"
SIZE_REMEDY = "vary the distance to the board, by a factor of two, between views"
OPPOSITE: dict[str, Camera] = {"on-arm": "beside", "beside": "on-arm"}
SIDES = {"on-arm": np.linalg.inv, "beside": np.asarray}
"""From a board's poses to those that :func:`.hand_eye` takes, by the camera."""
LEAST, LEAST_EACH = 5, 4
"""Fewest views, in all and in a recording: three leave no redundancy."""
LOOSE, MOST_OUTLIERS = 2e-2, 1 / 3
"""Scatter [m], and share of outliers, beyond which the pose is not to be relied on."""
TURNED_OVER = 2.5
"""Error beyond which a board was found turned by half a turn [rad]."""
OTHER_WAY = 0.25
"""Share of the remaining angles below which the inverse poses are taken for what was measured."""
NOTHING_FITS = 0.1
"""Typical angle that no arm and no detector errs by [rad]."""


@dataclass(frozen=True, repr=False)
class CameraPose(Found):
    """A camera's pose, estimated with the calibrated chain held."""

    camera: Camera
    target: Pose
    """The board in the base, or on the flange."""
    noise: tuple[float, float]
    """Of a board's place [m] and turn [rad], standard deviations per axis."""
    held_out: tuple[float, float]
    """Error of views that are left out, root mean squares of place [m] and turn [rad]."""
    residuals: np.ndarray
    """Errors of the views, shape (N, 6) [m, rad]."""
    outliers: tuple[str, ...]
    """Outliers among the views, in words."""
    size: float = 1.0
    """Factor on the places that the camera measured: the board's size by what was said of it."""
    size_told: bool = True
    """False where the views do not tell it, and it stays as it was said."""

    @property
    def quaternion(self) -> tuple[float, ...]:
        """Orientation of the camera, x y z w."""
        R = Pose.of(self.frame.origin).rotation
        return tuple(quaternion_of(R[None])[0].tolist())

    @property
    def brief(self) -> tuple[str, ...]:
        """The pose and how to publish it, line by line; reasons not to rely on it come first."""
        frame, (place, turn) = self.frame, self.held_out
        turned = signed(self.quaternion, 6)
        publisher = () if self.untold else ("For ROS 2:", f"  {self.publisher}")
        return (
            *self.untold,
            f"{frame.name} in {frame.parent}: {self.place}; qx qy qz qw {turned}",
            f"Views left out are {1e3 * place:.2f} mm and {1e3 * turn:.2f} mrad off (rms).",
            f"Multiply places that the camera measures by {self.size:.4f}."
            if self.size_told
            else SIZE_UNTOLD,
            *publisher,
            *self.notes,
            *self.outliers,
        )

    @property
    def scatter(self) -> str:
        """Scatter of the detector, in words."""
        place, turn = self.noise
        return f"The detector scatters by {1e3 * place:.2f} mm and {1e3 * turn:.2f} mrad an axis."

    @property
    def publisher(self) -> str:
        """The command that publishes the pose in ROS 2."""
        frame, names = self.frame, (*"xyz", "qx", "qy", "qz", "qw")
        pairs = zip(names, (*frame.xyz, *self.quaternion), strict=True)
        numbers = " ".join(f"--{name} {value:.6f}" for name, value in pairs)
        frames = f"--frame-id {frame.parent} --child-frame-id {frame.name}"
        return f"ros2 run tf2_ros static_transform_publisher {numbers} {frames}"

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        origin = self.target.origin
        return {
            **super().as_dict(),
            "quaternion": list(self.quaternion),
            "target": {"xyz": list(origin.xyz), "rpy": list(origin.rpy)},
            "noise": dict(zip(("place", "turn"), self.noise, strict=True)),
            "held_out": dict(zip(("place", "turn"), self.held_out, strict=True)),
        }


@one_blas_thread
def handeye(
    calibration: Calibration,
    data: Placement | Sequence[Placement],
    camera: Camera,
    name: str = "camera",
    *,
    limit: float = LIMIT,
    scale: Scale = "board",
) -> CameraPose:
    """Find where a camera is, by poses of a board in it.

    Args:
        calibration: The calibration; the arm is held as it left it, within its covariance.
        data: Joint positions and the board's poses in the camera (``poses.csv``), 15 or so, turned
            about two axes at least.
        camera: ``on-arm`` with the board fixed, ``beside`` with the board on the arm.
        name: Of the camera's link in the URDF.
        limit: Standard deviation in any direction, above which the views are not enough [m].
        scale: ``exact`` where an instrument measured the places, ``board`` where they are as large
            as a printed board was said to be.

    Raises:
        UsageError: Too few views, the other kind of camera, or poses the other way round.
        FrameError: The flange turns about one axis only.
        ModelError: The model already has a link of that name.
        MeasurementError: Samples of another arm.
    """
    _check_choice("--camera", camera, get_args(Camera))
    _check_choice("--scale", scale, get_args(Scale))
    prior = prior_of(calibration)
    with order_said(as_list(data), prior.robot.joint_names):
        task = camera_task(prior, as_list(data), camera)
        task = replace(task, exact_size=scale == "exact")
        system, wrong_size, size_told = with_right_size(fit(task))
    state = system.state
    if camera == "on-arm":
        pose, target = system.tool, system.place
        mount, parent = prior.ball, prior.robot.ball_joint.parent
    else:
        pose, target = system.place, system.tool
        mount, parent = task.places[0, :3], prior.robot.base
    zeros = changed_zeros(system, mount)
    inconsistent = _inconsistent(system)
    scatter = zeros.rival(system) if zeros.alike and not inconsistent else ()
    doubts = scatter or wrong_size or inconsistent or zeros.rival(system)
    if not doubts:
        subject = f"views cannot show {name} in {parent}"
        remedy = REMEDY if size_told else SIZE_REMEDY
        doubts = not_enough(zeros.covariance, limit, subject, remedy)
    return CameraPose(
        **vars(found(calibration, system, (name, parent), pose, zeros, doubts)),
        camera=camera,
        target=target,
        noise=(state.noise.place, state.noise.turn),
        held_out=_held_out(system),
        residuals=system.residuals,
        outliers=_outliers(system),
        size=float(np.exp(system.size)),
        size_told=size_told,
    )


def _check_choice(option: str, word: str, choices: Sequence[str]) -> None:
    if word not in choices:
        raise UsageError(f"{option} {word}: choose among {', '.join(choices)}")


def camera_task(
    prior: ArmPrior, placements: Sequence[Placement], camera: Camera
) -> Task:
    """Return the views of a board, with the camera's and the board's poses to be found."""
    where = ", ".join(str(p.files[0]) if p.files else p.name for p in placements)
    counts = [len(distinct(p).samples) for p in placements]
    if sum(counts) < LEAST or min(counts) < LEAST_EACH:
        raise UsageError(
            f"{where}: {' + '.join(map(str, counts))} views; {LEAST} are needed, and {LEAST_EACH} "
            "of each recording; 15 are advised"
        )
    data = [
        measure(replace(p, poses_of="camera"), prior.robot, poses_of="camera")
        for p in placements
    ]
    if not all(m.has_orientations for m in data):
        raise UsageError(
            f"{where}: no orientations; a view needs x,y,z,qx,qy,qz,qw of the board"
        )
    points = np.concatenate([m.points for m in data])
    B = as_poses(np.concatenate([m.rotations for m in data]), points)
    farthest = float(np.abs(points).max())
    if farthest > FARTHEST:
        raise UsageError(
            f"{where}: places up to {farthest:.0f} m away; are these millimetres?"
        )
    rows = Rows.of(prior, data, np.zeros(len(B), int), ("",))
    poses = prior.flanges(prior.mean, rows)
    starts = {way: poses.hand_eye(side(B), where) for way, side in SIDES.items()}
    misfit = _misfit(camera, starts, B)
    if misfit or starts[camera].distance > LOOSE:
        samples = [*chain.from_iterable(m.placement.samples for m in data)]
        reading = fitting_reading(samples, poses, SIDES[camera])
        if reading:
            raise UsageError(f"{where}: {reading}")
        in_order = any(p.order_note(prior.robot.joint_names) for p in placements)
        order = fitting_order(prior, rows.q, SIDES[camera](B)) if in_order else ""
        if order:
            raise UsageError(f"{where}: {order}")
    if misfit:
        raise UsageError(f"{where}: {misfit}")
    if camera == "on-arm":
        rows = replace(rows, turns=True, left=B)
    else:
        rows = replace(rows, turns=True, right=B)
    noise = replace(DETECTOR, joint=prior.noise.joint)
    free = dict.fromkeys(prior.ball, FAR)
    return Task(prior, rows, noise, free, start=starts[camera])


def _misfit(camera: Camera, starts: dict[str, HandEye], B: np.ndarray) -> str:
    """Return in words that poses fit the other kind of camera, or none; empty where they fit."""
    other = OPPOSITE[camera]
    angle, opposite_angle = starts[camera].angle, starts[other].angle
    if opposite_angle < OTHER_WAY * angle:
        mend = [
            f"use --camera {other}",
            "invert them, if they are the camera's in the board",
        ]
        if not (B[:, 2, 3] > 0).all():  # a camera sees only what is before it
            mend.reverse()
        return (
            f"{angle:.2g} rad are left by a camera {camera}, {opposite_angle:.2g} by one {other} "
            f"or by inverse poses: {'; or '.join(mend)}"
        )
    if angle > NOTHING_FITS:
        return (
            f"the poses fit no camera on or beside this arm ({angle:.2g} rad left): is it this "
            "arm's calibration? Do joints and poses belong together, in radians, and qx,qy,qz,qw "
            "in this order? Is the board turned over in some views?"
        )
    return ""


def _held_out(system: System) -> tuple[float, float]:
    """Return the rms errors of each view predicted from all others, outliers left out."""
    errors = system.held_out().reshape(-1, 2, 3)
    is_inlier = system.state.weights > OUTLIER
    lengths = np.linalg.norm(errors[is_inlier], axis=2)
    place, turn = np.sqrt(np.mean(lengths**2, axis=0)).tolist()
    return place, turn


def _inconsistent(system: System) -> tuple[str, ...]:
    """Return a warning where the views contradict each other, else nothing."""
    noise, weights = system.state.noise.place, system.state.weights
    bad = int(np.sum(weights < OUTLIER))
    if bad > MOST_OUTLIERS * len(weights):
        words = f"{bad} of {len(weights)} views fit no other: is the board turned over in some?"
        return (f"{words} Leave one kind of them out.",)
    if noise > LOOSE:
        words = f"The views scatter by {1e3 * noise:.0f} mm: are places mirrored, is the board's "
        return (f"{words}size right, and do joints and poses belong together?",)
    return ()


def _outliers(system: System) -> tuple[str, ...]:
    """Return the outliers among the views, in words."""
    lengths = np.linalg.norm(system.residuals.reshape(-1, 2, 3), axis=2).tolist()
    lines: list[str] = []
    for i, where in system.outliers("view").items():
        place, turn = lengths[i]
        over = " Was the board found turned over?" if turn > TURNED_OVER else ""
        lines.append(
            f"{where}: fits no other, {1e3 * place:.1f} mm and {1e3 * turn:.1f} mrad off; it has "
            f"little weight.{over}"
        )
    return tuple(lines)

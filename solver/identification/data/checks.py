"""Placements checked against the robot: joints, units, signs, numbers of samples, orientations."""

import math
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from ....errors import MukcaError
from ....recorder import Placement, numbers_of
from ..robot import BallModel, Robot
from .copies import check_distinct
from .instrument import check_orientations, other_columns
from .lengths import Readings, stated_length
from .measurements import (
    LimitsError,
    Load,
    Measurement,
    MeasurementError,
    TooFewError,
)
from .plausibility import with_plausible_efforts
from .sample_choice import counting, without_single

LEAST_POINTS = 4
"""Three points determine the instrument's frame, and nothing else."""
SAMPLES_ADVISED = "24 to 40 samples in two sockets, until record says ENOUGH"
"""Samples of a placement, in the words that all advice on their number uses."""
ENOUGH_POSES = 10
"""Fewest poses by which wrong columns of their orientations are recognised."""
_FAR_OUTSIDE = 1.0
"""Distance from its limits at which a joint cannot have been [rad or m]: the units are wrong."""
_BARELY_OUTSIDE = math.radians(5)
_LONGEST_SLIDE = 5.0
"""No joint slides farther [m]."""
_ENDLESS = 6 * math.pi
"""No joint without limits winds up its cables farther [rad]."""


def measure(
    placement: Placement,
    robot: Robot,
    distance: Readings | None = None,
    *,
    sockets: int = 2,
    poses_of: str = "flange",
    whole: bool = False,
    load: Load | None = None,
) -> Measurement:
    """Check a placement against the robot, and put its joints into chain order.

    Args:
        placement: The recording, see :func:`mukca.read_placements`.
        robot: The robot.
        distance: Between the sockets' centres [m], or readings; None: ``placement.json``'s,
            or :data:`.DEFAULT_DISTANCE` where that says nothing.
        sockets: Number of sockets that must have samples.
        poses_of: Meaning that orientations must have, see :attr:`.Placement.poses_of`.
        whole: True keeps equal samples, as older calibrations hold them.
        load: What efforts are held against; None to take them as they are.
    """
    ordered = placement.for_joints(robot.joint_names)
    numbers_of(ordered.positions, f"placement {placement.name!r}: positions")
    _check_names(placement, robot)
    ordered = counting(ordered, robot, whole=whole)
    if load is not None:
        ordered = with_plausible_efforts(ordered, robot, load)
    warnings = list(ordered.remarks)
    ordered = without_single(ordered, warnings)
    with order_said([placement], robot.joint_names):
        _check_limits(ordered, robot, warnings)
    length = stated_length(placement, distance, warnings)
    measured = Measurement(
        ordered,
        distance=length.distance,
        distance_source=length.source,
        distance_readings=length.readings,
        warnings=tuple(warnings),
    )
    if measured.kind == "points":
        _check_points(measured)
    elif robot.ball_unknown:
        flange = robot.ball_joint.parent
        raise MeasurementError(
            f"{placement.where}: in sockets, where the ball sits on {flange!r} must be known: "
            "--ball X Y Z"
        )
    else:
        _check_sockets(measured, sockets)
    with order_said([placement], robot.joint_names):
        _check_poses(measured, robot, poses_of)
    return measured


@contextmanager
def order_said(
    placements: Iterable[Placement], joint_names: Sequence[str]
) -> Generator[None]:
    """Let an error say that columns were taken in order, which may be its reason."""
    try:
        yield
    except MukcaError as error:
        notes = [p.order_note(joint_names) for p in placements]
        if any(notes):
            error.args = (f"{error}; {next(filter(None, notes))}",)
        raise


def as_flange_poses(placements: Iterable[Placement]) -> list[Placement]:
    """Return placements whose poses, unless they tell, are what an instrument saw of the flange."""
    return [replace(p, poses_of=p.poses_of or "flange") for p in placements]


def _check_names(placement: Placement, robot: Robot) -> None:
    """Refuse joint names of a placement made in memory none of which is the robot's."""
    if placement.files or not placement.order_note(robot.joint_names):
        return
    joints = ", ".join(robot.joint_names)
    names = ", ".join(placement.joint_names or ())
    raise MeasurementError(
        f"{placement.name}: no joint of the robot ({joints}) is among its joint names "
        f"({names}); give the robot's names, or none for the robot's order"
    )


def _check_poses(measured: Measurement, robot: Robot, meaning: str) -> None:
    """Refuse orientations of something else, or that do not turn as the robot does."""
    if not measured.has_orientations:
        return
    placement = measured.placement
    where = placement.first_file
    if placement.poses_of != meaning:
        reason = "does not tell what its poses are"
        if placement.poses_of is not None:
            reason = f"holds poses of another kind: {placement.poses_of}"
        raise MeasurementError(
            f"{where}: {reason}; where an instrument measured what the flange carries, let the "
            'first line be "# measured flange poses", or write {"poses_of": "flange"} into '
            "placement.json. Or give --flange-poses to check, solve or validate"
        )
    if meaning == "flange" and len(placement.samples) >= ENOUGH_POSES:
        ball = BallModel(robot, [])
        none = np.zeros(0)
        q = measured.positions
        R = ball.rotations(none, q).points
        columns = other_columns(robot.joint_names, q)
        mended = (
            (words, ball.rotations(none, other).points) for words, other in columns
        )
        check_orientations(R, measured.quaternions, str(where), mended)


def _check_points(measured: Measurement) -> None:
    """Refuse measured points that are too few, or of one configuration."""
    where = measured.placement.first_file
    N = len(measured.positions)
    if N < LEAST_POINTS:
        raise TooFewError(
            f"{where}: {N} measured points; at least {LEAST_POINTS} are needed, 50 are advised"
        )
    if not np.ptp(measured.positions, axis=0).any():
        raise TooFewError(
            f"{where}: all {N} points are of one configuration; move the arm"
        )


def _check_sockets(measured: Measurement, minimum: int) -> None:
    """Refuse too few sockets, or samples in them, and samples given twice."""
    where = measured.placement.where
    if len(measured.sockets) < minimum:
        raise TooFewError(
            f"{where}: only socket {measured.sockets[0]} has samples; the distance between two "
            "sockets sets the scale, so record hole_0.csv and hole_1.csv, or tie it by --known"
        )
    for socket, rows in zip(measured.sockets, measured.by_socket, strict=True):
        first = next(s for s in measured.placement.samples if s.socket == socket)
        if len(rows) < 2:
            raise TooFewError(
                f"{first.where or where}: one sample in socket {socket}; at least 2 are "
                f"needed, better {SAMPLES_ADVISED}"
            )
        if not np.ptp(rows, axis=0).any():
            raise TooFewError(
                f"{first.where or where}: all {len(rows)} samples of socket {socket} are "
                "the same configuration; guide the arm to another one for each"
            )
    check_distinct([measured])


def _check_limits(placement: Placement, robot: Robot, warnings: list[str]) -> None:
    """Refuse joint positions far outside of the limits, and warn of those outside."""
    positions = placement.positions
    endless = np.isinf(robot.lower) & np.isinf(robot.upper)
    lower = np.where(endless, -_ENDLESS, robot.lower)
    upper = np.where(endless, _ENDLESS, robot.upper)
    excess = np.maximum(lower - positions, positions - upper)
    row, column = divmod(int(np.argmax(excess)), len(lower))
    joint = robot.actuated[column]
    value = positions[row, column]
    slides = joint.type == "prismatic"
    where = placement.samples[row].where or placement.name
    text = (
        f"{where}: joint {joint.name!r} at {value:.4g} is outside its limits, "
        f"{lower[column]:.4g} to {upper[column]:.4g} {'m' if slides else 'rad'}"
    )
    if excess.max() > _FAR_OUTSIDE:
        turned = -positions[:, column]
        if lower[column] <= turned.min() and turned.max() <= upper[column]:
            raise LimitsError(
                f"{text}; all of its column lies inside with the other sign: is it sign-flipped? "
                f"Then turn it by --columns q=1..{column},-{column + 1},{column + 2}..{len(lower)}"
            )
        unit = "lengths are metres" if slides else "angles are radians"
        guess = "is it another robot?"
        if len(lower) in np.bincount(placement.sockets):
            guess = "is it another robot, or is a line a joint, where it should be a sample?"
        if slides and abs(value) > _LONGEST_SLIDE:
            guess = "are these millimetres? a header of JOINT [mm] is read as such"
        elif not slides and abs(positions).max() > 2 * np.pi:
            advice = placement.advice("a header of JOINT [deg] is read as such")
            guess = f"are these degrees? {advice}"
        raise LimitsError(
            f"{text}; {unit} ({guess}), in the order of the chain's joints"
        )
    if excess.max() > _BARELY_OUTSIDE:
        warnings.append(f"{text}; the sample is used")

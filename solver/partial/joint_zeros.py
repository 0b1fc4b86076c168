"""Zeros of joints after an exchange, a crash or a reset, with the calibrated chain held."""

from collections.abc import Sequence
from dataclasses import replace

from ...recorder import Placement
from ..calibration import Calibration, UsageError, as_list
from ..identification.data import Measurement, check_distinct, measure, one_blas_thread
from ..identification.robot import Robot
from .found_zeros import Zeros, still_off
from .prior import ANGLE, LENGTH, TOLERANCES, prior_of
from .sockets import (
    new_samples,
    on_base_of,
    require_samples,
    similar_postures,
    socket_task,
)
from .task import Task
from .zero_posterior import ZeroPosterior, find_zeros

OTHER_ARM = 5.0
"""Factor on the errors of the calibration, beyond which zeros alone do not explain the samples."""
OTHER_MODEL = 2e-2
"""Errors beyond which zeros alone do not explain samples by a nominal model [m]."""
BALL_ELSEWHERE = 0.1
"""Prior standard deviation of the place of a ball that was remounted [m]."""
ANOTHER = 5e-2
"""Errors beyond which samples are another arm's, even where no zero changed [m]."""


@one_blas_thread
def rezero(
    arm: Calibration | Robot,
    data: Placement | Sequence[Placement],
    joints: Sequence[str] = (),
    stood: str = "",
    *,
    ball_moved: bool = False,
    distance: float | None = None,
) -> Zeros:
    """Find the zeros of joints after an exchange, a crash or a reset; nothing is sent to an arm.

    Everything else is held as the calibration left it, and moves as far as its covariance allows.

    Args:
        arm: The calibration; or a nominal robot, whose parts may be less exact than printed ones.
        data: Samples since, with the ball in sockets: 6 in each are enough.
        joints: Joints whose zero changed; empty where the evidence is to say which.
        stood: Placement of the calibration whose base still stands where it stood. One socket of it
            is enough then, and the first joint's zero is told, too.
        ball_moved: The ball was taken off since, and sits elsewhere.
        distance: Between the sockets' centres [m]; None for the recording's or else the base's.

    Raises:
        UsageError: No such joint or placement, a calibration that leaves no posterior or is another
            arm's, or fewer samples than unknowns.
        MeasurementError: Samples of another arm, or too few.
    """
    prior = prior_of(arm)
    robot = prior.robot
    numbers = _joint_numbers(robot, joints)
    placements = as_list(data)
    if distance is None:
        placements = [on_base_of(arm, placement) for placement in placements]
    measured = [
        measure(placement, robot, distance, sockets=1, load=prior.load)
        for placement in placements
    ]
    check_distinct(measured)
    measured, new, remarks = new_samples(arm, measured)
    task = _remarked(socket_task(prior, measured, stood), measured, remarks)
    if ball_moved:
        task = task.freeing(dict.fromkeys(prior.ball, BALL_ELSEWHERE))
    require_samples(task, len(numbers) or len(robot.joint_names))
    factors = TOLERANCES if isinstance(arm, Robot) else {1.0: 1.0}
    posterior = find_zeros(task, numbers, factors)
    system, zeros = posterior.system, posterior.joints
    _refuse_other_arm(arm, posterior)
    if not new:
        zeros = tuple(replace(zero, changed=0.0, offset=0.0) for zero in zeros)
    return Zeros(
        arm,
        zeros,
        posterior.unchanged if new else None,
        system.state.noise.place,
        _untold(posterior, robot, joints or robot.joint_names, stood),
        system,
        new,
        other=posterior.factor > 1,
        scatter=posterior.scatter_text,
    )


def _joint_numbers(robot: Robot, joints: Sequence[str]) -> list[int]:
    """Return the numbers of named joints.

    Raises:
        UsageError: There is none of that name.
    """
    names = robot.joint_names
    for joint in joints:
        if joint not in names:
            raise UsageError(f"--joint {joint}: the joints are {', '.join(names)}")
    return [names.index(joint) for joint in joints]


def _remarked(task: Task, data: Sequence[Measurement], remarks: Sequence[str]) -> Task:
    """Return a task with remarks on its samples, and that on postures which are alike."""
    warnings = [*task.rows.warnings, *remarks]
    if similar_postures(data):
        warnings.append(
            "The postures are alike and tell little: move all joints between samples."
        )
    return replace(task, rows=replace(task.rows, warnings=tuple(warnings)))


def _refuse_other_arm(arm: Calibration | Robot, posterior: ZeroPosterior) -> None:
    """Refuse samples that zeros leave farther off than this arm's can be.

    Raises:
        UsageError: They are.
    """
    system, limit = posterior.system, OTHER_MODEL
    if isinstance(arm, Calibration):
        changed = any(zero.offset for zero in posterior.joints)
        limit = OTHER_ARM * system.task.prior.noise.space if changed else ANOTHER
    scatter = posterior.scatter_text and posterior.is_of_another_arm
    if scatter or system.rms_error > limit:
        raise UsageError(still_off(system))


def _untold(
    posterior: ZeroPosterior, robot: Robot, joints: Sequence[str], stood: str
) -> tuple[str, ...]:
    """Return what the samples cannot tell of the zeros of joints, and what would help."""
    blind = [joint for joint in posterior.blind if joint in joints]
    sentences = [_how_to_identify(robot, joint, stood) for joint in blind]
    if posterior.factor > 1:
        thousands = 1e3 * posterior.factor
        length, angle = thousands * LENGTH, thousands * ANGLE
        sentences += [
            "The nominal model's own errors look like changed zeros, so deviations "
            f"contain them: its lengths are off by some {length:.2g} mm and its angles by "
            f"{angle:.2g} mrad.",
            "If it is this arm's model, calibrate the arm first by mukca solve, which finds its "
            "zeros, too. Then give mukca rezero the calibration in place of the model.",
        ]
    return tuple(sentences)


def _how_to_identify(robot: Robot, joint: str, stood: str) -> str:
    """Return a sentence on a zero that is not identifiable, and samples that would help."""
    why, way = "", "Record more postures, in which it moves the ball differently"
    if joint == robot.joint_names[0] and not stood:
        why = ", because the base's place is free"
        way = "Leave a base where it stood, and name it by --stood"
    elif joint == robot.joint_names[-1]:
        why = ", because the ball lies on its axis or its own place is free"
        way = "Put a ball beside the axis"
    return f"These samples cannot show the zero of {joint}{why}. {way}."

"""Zeros of joints after an exchange, a crash or a reset, with the calibrated chain held."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...recorder import Placement
from ..calibration import Calibration, UsageError, as_list
from ..data import Measurement, measure
from ..results import refuse_existing, write_files
from ..robot import Robot
from .prior import ANGLE, LENGTH, TOLERANCES, prior_of
from .sockets import new_samples, require_samples, similar_postures, socket_task
from .system import System
from .task import Task
from .updated import updated, urdf_with_zeros
from .zero_posterior import SURE, find_zeros
from .zeros import TICK, JointZero

EVEN = 0.5
"""Probability of no change below which some zero may have changed."""
OTHER_ARM = 5.0
"""Factor on the errors of the calibration, beyond which zeros alone do not explain the samples."""
OTHER_MODEL = 2e-2
"""Errors beyond which zeros alone do not explain samples by a nominal model [m]."""
BALL_ELSEWHERE = 0.1
"""Prior standard deviation of the place of a ball that was remounted [m]."""
ANOTHER = 5e-2
"""Errors beyond which samples are another arm's, even where no zero changed [m]."""


@dataclass(frozen=True)
class Zeros:
    """Changes of joint zeros, estimated with the calibrated chain held."""

    arm: Calibration | Robot
    joints: tuple[JointZero, ...]
    """All of the arm's, in chain order."""
    unchanged: float | None
    """Probability that none changed; None where joints were named."""
    noise: float
    """Of the ball in its sockets, a standard deviation per axis [m]."""
    untold: tuple[str, ...]
    """Joints whose zeros are not identifiable, and samples that would help; or another warning."""
    system: System
    """The fit."""
    new: bool = True
    """False where the calibration was trained on all samples, so that they show no change."""
    other: bool = False
    """True where more than zeros differ from a nominal model."""

    @property
    def decided(self) -> bool:
        """True where the samples say which zeros changed, or that none did."""
        likely = self.unchanged is None or self.unchanged >= EVEN
        return self.new and (likely or bool(self.changed))

    @property
    def changed(self) -> tuple[JointZero, ...]:
        """The joints whose zero changed, of those that are identifiable."""
        return tuple(joint for joint in self.joints if joint.offset)

    def __repr__(self) -> str:
        return "\n".join(self.text) or "Nothing was found."

    @property
    def calibration(self) -> Calibration | None:
        """The calibration with the new zeros; None of an arm that has none."""
        if isinstance(self.arm, Robot):
            return None
        return updated(self.arm, self.system, self.joints)

    def urdf(self) -> bytes:
        """Return the URDF with the new zeros in its origins."""
        if isinstance(self.arm, Robot):
            return urdf_with_zeros(self.arm, [joint.offset for joint in self.joints])
        return updated(self.arm, self.system, self.joints).urdf()

    def save(self, folder: str | Path, *, force: bool = False) -> dict[str, str]:
        """Write ``calibrated.urdf`` and ``calibration.json``; the URDF alone for a nominal robot.

        Raises:
            OutputError: The folder is there already, or cannot be written.
            UsageError: The calibration was trained on all samples.
        """
        if not self.new:
            raise UsageError(
                "nothing was found that could be written: no sample is new"
            )
        if self.calibration is not None:
            return self.calibration.save(folder, force=force, accept_distorted=True)
        refuse_existing(Path(folder), force=force)
        return {
            "urdf": str(
                *write_files(Path(folder), {"calibrated.urdf": self.urdf()}).values()
            )
        }

    @property
    def brief(self) -> tuple[str, ...]:
        """The answer in words, line by line."""
        evidence = () if self.decided else (self._evidence,)
        return self._lines([zero.brief for zero in self.changed], evidence)

    @property
    def text(self) -> tuple[str, ...]:
        """The result in words, line by line, the answer first."""
        return self._lines(list(map(str, self.changed)), (self._evidence,))

    def _lines(self, zeros: Sequence[str], evidence: Sequence[str]) -> tuple[str, ...]:
        """Return the zeros, what the evidence says, what is not identifiable, and remarks."""
        notes = self.system.task.rows.warnings
        if not self.new:
            return (*notes, *self.untold)
        if self.unchanged is None or not any(zero.told for zero in self.joints):
            return (*zeros, *self.untold, *notes)
        if not (
            self.decided or self.unchanged or any(zero.changed for zero in self.joints)
        ):
            off = f"No zeros explain it: {_still_off(self.system)}"
            return (off, *self.untold, *notes)
        return (*zeros, *self._none, *evidence, *self.untold, *notes)

    @property
    def _none(self) -> tuple[str, ...]:
        """A sentence where no zero is named; none where one is, and that suffices."""
        unchanged = self.unchanged or 0.0
        if not self.decided:
            may = "changed" if unchanged < 1 - SURE else "may have changed"
            advice = "" if self.other else ": record more samples"
            return (f"Some zero {may}, and it cannot be told which{advice}.",)
        if self.changed:
            return ()
        if self.other:
            return ("No zero is shown to have changed.",)
        return (f"No zero changed ({100 * unchanged:.0f} %).",)

    @property
    def _evidence(self) -> str:
        """The probabilities that zeros changed, in words."""
        probabilities = ", ".join(
            f"{zero.joint} {100 * zero.changed:.0f} %"
            for zero in self.joints
            if zero.told
        )
        return f"Changed, by the evidence: {probabilities}."

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        rows = [
            {
                **asdict(joint),
                "told": joint.told,
                "degrees": joint.degrees,
                "ticks": joint.offset / TICK,
                "homing_offset": {"feetech": -joint.counts, "dynamixel": joint.counts},
            }
            for joint in self.joints
        ]
        return {
            "joints": rows,
            "changed": [joint.joint for joint in self.changed],
            "unchanged": self.unchanged,
            "noise": self.noise,
            "untold": list(self.untold),
        }


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
        arm: The calibration; or a nominal robot whose parts are as exact as printed ones are.
        data: Samples since, with the ball in sockets: 6 in each are enough.
        joints: Joints whose zero changed; empty where the evidence is to say which.
        stood: Placement of the calibration whose base still stands where it stood. One socket of it
            is enough then, and the first joint's zero is told, too.
        ball_moved: The ball was taken off since, and sits elsewhere.
        distance: Between the sockets' centres [m]; None for the recording's.

    Raises:
        UsageError: No such joint or placement, a calibration that leaves no posterior or is another
            arm's, or fewer samples than unknowns.
        MeasurementError: Samples of another arm, or too few.
    """
    prior = prior_of(arm)
    names = prior.robot.joint_names
    for joint in joints:
        if joint not in names:
            raise UsageError(f"--joint {joint}: the joints are {', '.join(names)}")
    measured = [
        measure(p, prior.robot, distance, sockets=1, load=prior.load)
        for p in as_list(data)
    ]
    measured, new, remarks = new_samples(arm, measured)
    task = _remarked(socket_task(prior, measured, stood), measured, remarks)
    if ball_moved:
        task = task.freeing(dict.fromkeys(prior.ball, BALL_ELSEWHERE))
    require_samples(task, len(joints) or len(names))
    factors = TOLERANCES if isinstance(arm, Robot) else {1.0: 1.0}
    posterior = find_zeros(task, [names.index(joint) for joint in joints], factors)
    system, zeros = posterior.system, posterior.joints
    _refuse_far(arm, system, changed=any(zero.offset for zero in zeros))
    if not new:
        zeros = tuple(replace(zero, changed=0.0, offset=0.0) for zero in zeros)
    asked = joints or names
    blind = [joint for joint in posterior.blind if joint in asked]
    untold = [_how_to_identify(prior.robot, joint, stood) for joint in blind]
    inexact = posterior.factor > 1
    if inexact:
        untold += _errors_of_model(posterior.factor)
    return Zeros(
        arm,
        zeros,
        posterior.unchanged if new else None,
        system.state.noise.place,
        tuple(untold),
        system,
        new,
        other=inexact,
    )


def _remarked(task: Task, data: Sequence[Measurement], remarks: Sequence[str]) -> Task:
    """Return a task with remarks on its samples, and that on postures which are alike."""
    warnings = [*task.rows.warnings, *remarks]
    if similar_postures(data):
        warnings.append(
            "The postures are alike and tell little: move all joints between samples."
        )
    return replace(task, rows=replace(task.rows, warnings=tuple(warnings)))


def _refuse_far(arm: Calibration | Robot, system: System, *, changed: bool) -> None:
    """Refuse samples that zeros leave farther off than this arm's can be.

    Raises:
        UsageError: They are.
    """
    limit = OTHER_MODEL
    if isinstance(arm, Calibration):
        limit = OTHER_ARM * system.task.prior.noise.space if changed else ANOTHER
    if _off(system) > limit:
        raise UsageError(_still_off(system))


def _off(system: System) -> float:
    """Return the root mean square of the errors that are left [m]."""
    return float(np.sqrt(np.mean(system.residuals**2)))


def _still_off(system: System) -> str:
    """Return that zeros leave the samples far off, and what else may be wrong."""
    usual = system.task.prior.noise.space
    return (
        f"the samples are still {1e3 * _off(system):.2f} mm off, and {1e3 * usual:.2f} are usual: "
        "is --distance right, is it another arm's calibration or model, "
        "or did more than zeros change (mukca check --calibration)?"
    )


def _errors_of_model(factor: float) -> tuple[str, ...]:
    """Return that a nominal model's own errors look like changed zeros, and what would help.

    They are as large as a factor on the tolerances of its parts says.
    """
    length, angle = 1e3 * factor * LENGTH, 1e3 * factor * ANGLE
    return (
        "The nominal model's own errors cannot be told from changed zeros, so deviations contain "
        f"them: its lengths are off by some {length:.2g} mm and its angles by {angle:.2g} mrad.",
        "Calibrate the arm first by mukca solve, which finds its zeros, too. Then give mukca "
        "rezero the calibration in place of the model.",
    )


def _how_to_identify(robot: Robot, joint: str, stood: str) -> str:
    """Return a sentence on a zero that is not identifiable, and samples that would help."""
    why, way = "", "Record more postures, in which it moves the ball differently"
    if joint == robot.joint_names[0] and not stood:
        why = ", because the base's place is free"
        way = "Leave a base where it stood, and name it by --stood"
    elif joint == robot.joint_names[-1]:
        why = ", because the ball lies on its axis or its own place is free"
        way = "Put a ball beside the axis"
    return f"These samples cannot tell the zero of {joint}{why}. {way}."

"""lerobot's calibration file of an arm made of servos, its zeros corrected by those estimated.

A joint whose true angle is its reading plus z gets there by n = round(4096 z / 2 pi) ticks less in
its homing offset (Feetech), or more (Dynamixel); its range stays, or the shift would be cancelled.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from ...drivers.arms.servos import MotorCalibration, read_lerobot
from ...errors import fixed, read_bytes
from .request import Exported, ExportError, Request, losses_without
from .zeros import UNDECIDED, JointZero, estimated_zeros, urdf_without

TICK = 2 * math.pi / 4096
SIGNS = {"feetech": -1, "dynamixel": 1}
"""Sign of a homing offset in the position, by the make of the servos."""
MOST_TICKS = 100
"""A larger shift would bring the servo's own limits too far off the joint's [ticks]."""
LARGEST_OFFSET = {"feetech": 2047, "dynamixel": 1 << 20}


@dataclass(frozen=True)
class Zero:
    """The estimated zero of one joint."""

    joint: str
    motor: str
    zero: float
    """To be added to the reading [rad]."""
    deviation: float
    ticks: int
    """By how much the position is to grow; 0 where nothing is written."""
    why: str = ""
    """The reason that nothing is written."""

    def __str__(self) -> str:
        angle = JointZero(self.joint, self.zero, self.deviation)
        return f"{self.motor:14} {angle}, {self.why or fixed(self.ticks, 0, '+') + ' ticks'}"


def write(request: Request) -> Exported:
    """Return the new file, the URDF that goes with it, and the digests of what they are from."""
    make = request.options.get("servos")
    if not request.like or make is None:
        raise ExportError(
            "--to lerobot needs --like FILE, the arm's present calibration file, and --servos "
            f"{' or '.join(SIGNS)}"
        )
    if (
        request.file.suffix != ".json"
        or request.file.resolve() == request.like.resolve()
    ):
        raise ExportError(
            f"--out {request.file}: name another .json file than the present one"
        )
    motors = read_lerobot(request.like)
    zeros = _zeros(request, motors)
    made_from = {
        **asdict(request.identity),
        "calibration_file": request.like.name,
        "calibration_file_sha256": hashlib.sha256(read_bytes(request.like)).hexdigest(),
        "zeros": [asdict(zero) for zero in zeros],
    }
    urdf = f"{request.file.stem}.urdf"
    files = {
        request.file.name: _as_json(_shifted(motors, zeros, make)),
        f"{request.file.name}.mukca.json": f"{json.dumps(made_from, indent=2)}\n".encode(),
        urdf: urdf_without(request, [zero.ticks * TICK for zero in zeros]),
    }
    most = max(abs(zero.ticks) for zero in zeros)
    lines = [*map(str, zeros)]
    if most:
        lines += [
            f"lerobot loads {request.file}, and asks once whether to write it to the motors; it "
            "has no effect before.",
            f"Then load {urdf}, not calibrated.urdf, which holds the old zeros.",
            f"The recorded ends stay: the joints' own lie up to {most} ticks off them. Policies "
            "that were trained before see other angles.",
        ]
    else:
        lines += [
            f"Nothing changes: every homing offset is that of {request.like} already.",
            f"Load {urdf} or calibrated.urdf.",
        ]
    return Exported(files, losses_without(request), tuple(lines))


def with_zeros(
    like: Path,
    make: str,
    joints: Sequence[str],
    ticks: Mapping[str, int],
) -> bytes:
    """Return lerobot's file, by which the positions of some of an arm's joints grow by ticks."""
    motors = read_lerobot(like)
    by_motor = _motors_of(like, joints, motors)
    zeros = [Zero(j, by_motor[j], n * TICK, 0.0, n) for j, n in ticks.items()]
    return _as_json(_shifted(motors, zeros, make))


def _as_json(motors: Mapping[str, MotorCalibration]) -> bytes:
    """Return lerobot's file of motors."""
    written = {name: asdict(motor) for name, motor in motors.items()}
    return (json.dumps(written, indent=4) + "\n").encode()


def _zeros(request: Request, motors: Mapping[str, MotorCalibration]) -> list[Zero]:
    """Return the estimated zero of each joint, in chain order, and its ticks."""
    estimates = estimated_zeros(request)
    joints = [estimate.joint for estimate in estimates]
    by_motor = _motors_of(request.like or Path(), joints, motors)
    zeros: list[Zero] = []
    for estimate in estimates:
        joint, zero, deviation = estimate
        ticks = round(zero / TICK)
        why = ""
        if not estimate.decided:
            why = UNDECIDED
        elif abs(ticks) > MOST_TICKS:
            why = f"{fixed(ticks, 0, '+')} ticks are too many: calibrate by lerobot anew first"
        ticks *= not why
        zeros.append(Zero(joint, by_motor[joint], zero, deviation, ticks, why))
    return zeros


def _motors_of(
    like: Path, joints: Sequence[str], motors: Mapping[str, MotorCalibration]
) -> dict[str, str]:
    """Return the motor of each joint: that of its name, else that of its place along the arm.

    The ids of an arm's motors count from 1 at its base. The order in the file means nothing.
    """
    if set(joints) <= set(motors):
        return {joint: joint for joint in joints}
    by_motor: dict[str, str] = {}
    for number, joint in enumerate(joints, 1):
        candidates = [name for name, motor in motors.items() if motor.id == number]
        if len(candidates) != 1:
            what = f"{', '.join(candidates)} all have" if candidates else "no motor has"
            raise ExportError(
                f"{like}: {what} the id {number}, by which the motor of {joint} is known; "
                "give the file of this arm alone, or call its motors as the model its joints: "
                f"{', '.join(joints)}"
            )
        by_motor[joint] = candidates[0]
    return by_motor


def _shifted(
    motors: Mapping[str, MotorCalibration], zeros: list[Zero], make: str
) -> dict[str, MotorCalibration]:
    """Return the motors with their homing offsets shifted, and nothing else."""
    shifted = dict(motors)
    for zero in zeros:
        motor = motors[zero.motor]
        offset = motor.homing_offset + SIGNS[make] * zero.ticks
        if abs(offset) > LARGEST_OFFSET[make]:
            raise ExportError(
                f"{zero.motor}: no servo takes a homing offset of {offset}: "
                "mount its horn nearer to the middle, and calibrate the arm in lerobot again"
            )
        shifted[zero.motor] = replace(motor, homing_offset=offset)
    return shifted

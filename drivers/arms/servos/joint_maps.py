"""Joint maps of arms made of servos, 4096 ticks a turn: q = sign * (position - zero) * 2 pi / 4096.

An address's ``ids``, ``signs``, ``zeros`` and ``calibration`` take the place of the table's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, cast

from ....errors import MukcaError, read_beside, read_json
from ... import JointNames, JointValues, Reason
from ...transport import Options

TICKS = 4096
"""In a turn."""
OPTIONS = ("arm", "ids", "signs", "zeros", "calibration")
MIDDLE = TICKS // 2


@dataclass(frozen=True)
class ServoMap:
    """The servos of one arm, from base to flange, without the gripper's."""

    joints: JointNames
    ids: tuple[int, ...]
    signs: tuple[int, ...]
    zeros: JointValues
    """Positions at which the angles are zero [ticks]."""
    homing: tuple[int, ...] | None = None
    """Homing offsets that the servos must have for these zeros to hold [ticks]."""


def _map(
    joints: Sequence[str], ids: Sequence[int], degrees: Sequence[float] = ()
) -> ServoMap:
    """Return a map by the middle of each servo, where the model's angle is so many degrees."""
    zeros = tuple(MIDDLE - angle / 360 * TICKS for angle in degrees or [0.0] * len(ids))
    return ServoMap(tuple(joints), tuple(ids), (1,) * len(ids), zeros)


_TABLE: dict[str, dict[str, Any]] = read_beside(__file__, "arms.json")


def maps_of(make: str) -> dict[str, ServoMap]:
    """Return the maps of a maker's arms by name.

    Of so100 the zeros are the middle of the ranges in so100.urdf, which are not lerobot's. Servos 3
    and 5 of ViperX and WidowX only help 2 and 4.
    """
    joints: dict[str, list[str]] = _TABLE["joints"]
    return {
        name: _map(joints[arm["joints"]], arm["ids"], arm.get("degrees", ()))
        for name, arm in _TABLE[make].items()
    }


def choose_map(
    options: Options, arms: dict[str, ServoMap], default: str | None
) -> ServoMap:
    """Return the map that an address asks for, of a driver's arms; one by default, or by ids."""
    name = options.get("arm", default)
    if name is None and "ids" not in options:
        raise Reason.BAD_ADDRESS(
            f"say which arm it is: ?arm= one of {', '.join(arms)}, or ?ids=.."
        )
    if name is not None and name not in arms:
        raise options.wrong("arm", f"one of {', '.join(arms)}")
    if "ids" in options:
        ids = options.integers("ids", ())
        count = len(ids)
        if len(set(ids)) != count or not all(0 <= servo < 253 for servo in ids):
            raise options.wrong("ids", "a list of the joints' servos, as in 1,2,4,6,7")
        servo_map = _map([f"joint{index}" for index in range(1, count + 1)], ids)
    else:
        servo_map = arms[name or ""]
    signs = options.signs(len(servo_map.ids))
    zeros = options.numbers(
        "zeros",
        servo_map.zeros,
        lambda zero: abs(zero) < 1e6,
        f"a position in ticks for each joint ({len(signs)})",
    )
    servo_map = replace(servo_map, signs=signs, zeros=zeros)
    return _calibrated(servo_map, options) if "calibration" in options else servo_map


def _calibrated(servo_map: ServoMap, options: Options) -> ServoMap:
    """Take the zeros from a calibration file of lerobot's."""
    path = Path(options["calibration"]).expanduser()
    try:
        motors = {motor.id: motor for motor in read_lerobot(path).values()}
    except MukcaError as error:
        raise Reason.BAD_ADDRESS(str(error)) from None
    for joint, servo in zip(servo_map.joints, servo_map.ids, strict=True):
        if servo not in motors:
            raise Reason.BAD_ADDRESS(f"{path}: no motor has id {servo} ({joint})")
    homing = tuple(motors[servo].homing_offset for servo in servo_map.ids)
    # The table's own zeros say what the model's angle is at the middle.
    zeros = tuple(
        motors[servo].middle + zero - MIDDLE
        for servo, zero in zip(servo_map.ids, servo_map.zeros, strict=True)
    )
    return replace(servo_map, zeros=zeros, homing=homing)


@dataclass(frozen=True, slots=True)
class MotorCalibration:
    """Calibration of one motor by lerobot.

    lerobot counts a joint's angle from the middle of its range::

        degrees = (position - (range_min + range_max) / 2) * 360 / 4095

    and this package in the servo's true ticks, 4096 a turn. ``drive_mode`` turns no angle.
    """

    id: int
    """Number of the servo on its bus."""
    drive_mode: int
    homing_offset: int
    """Shift that the servo itself adds to its position [ticks]."""
    range_min: int
    """Ends of the joint's range [ticks]."""
    range_max: int

    @property
    def middle(self) -> float:
        """The position at which the joint's angle is zero [ticks]."""
        return (self.range_min + self.range_max) / 2


KEYS = tuple(field.name for field in fields(MotorCalibration))


def read_lerobot(path: Path) -> dict[str, MotorCalibration]:
    """Read a calibration file of lerobot's, motors by name; a MukcaError if it is none."""
    try:
        content: object = read_json(path)
    except OSError as error:
        raise MukcaError(f"{path}: {error.strerror or 'cannot be read'}") from None
    except ValueError as error:
        raise MukcaError(
            f"{path}: not a calibration file of lerobot's: {error}"
        ) from None
    if not isinstance(content, dict) or not content:
        raise MukcaError(
            f"{path}: not a calibration file of lerobot's: no motors by name"
        )
    motors = cast("dict[str, object]", content)
    return {name: _motor(path, name, motor) for name, motor in motors.items()}


def _motor(path: Path, name: str, motor: object) -> MotorCalibration:
    values = cast("dict[str, int]", motor) if isinstance(motor, dict) else {}
    if set(values) != set(KEYS) or any(
        type(value) is not int for value in values.values()
    ):
        raise MukcaError(
            f"{path}: motor {name!r} needs whole numbers for {', '.join(KEYS)} alone"
        )
    calibration = MotorCalibration(**values)
    if calibration.range_min >= calibration.range_max:
        raise MukcaError(f"{path}: motor {name!r}: range_min is not below range_max")
    return calibration

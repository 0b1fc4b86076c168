"""lerobot's calibration file of an arm: where the zero of each servo is.

One object a motor, with five whole numbers each::

    {"shoulder_pan": {"id": 1, "drive_mode": 0, "homing_offset": -50,
                      "range_min": 500, "range_max": 3500}, ...}

lerobot counts a joint's angle from the middle of its range, in ticks of the servo's position::

    degrees = (position - (range_min + range_max) / 2) * 360 / 4095

and this package in the servo's true ticks, 4096 a turn. ``drive_mode`` turns no angle in degrees.
"""

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import cast

from ....errors import MukcaError


@dataclass(frozen=True, slots=True)
class MotorCalibration:
    """What the file holds for one motor."""

    id: int
    """Number of the servo on its bus."""
    drive_mode: int
    homing_offset: int
    """By how much the servo itself shifts its position [ticks]."""
    range_min: int
    """Ends of the range that the joint was moved through [ticks]."""
    range_max: int

    @property
    def middle(self) -> float:
        """The position at which the joint's angle is zero [ticks]."""
        return (self.range_min + self.range_max) / 2


KEYS = tuple(field.name for field in fields(MotorCalibration))


def read_lerobot(path: Path) -> dict[str, MotorCalibration]:
    """Read a calibration file of lerobot's.

    Returns:
        What it holds for each motor, by name, in the file's order.

    Raises:
        MukcaError: The file cannot be read, or is no such file.
    """
    try:
        content: object = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise MukcaError(f"{path}: {error.strerror or 'cannot be read'}") from None
    except ValueError as error:
        raise MukcaError(f"{path}: not a calibration file of lerobot's: {error}") from None
    if not isinstance(content, dict) or not content:
        raise MukcaError(f"{path}: not a calibration file of lerobot's: no motors by name")
    motors = cast("dict[str, object]", content)
    return {name: _motor(path, name, motor) for name, motor in motors.items()}


def _motor(path: Path, name: str, motor: object) -> MotorCalibration:
    values = cast("dict[str, int]", motor) if isinstance(motor, dict) else {}
    if set(values) != set(KEYS) or any(type(value) is not int for value in values.values()):
        raise MukcaError(f"{path}: motor {name!r} needs whole numbers for {', '.join(KEYS)} alone")
    calibration = MotorCalibration(**values)
    if calibration.range_min >= calibration.range_max:
        raise MukcaError(f"{path}: motor {name!r}: range_min is not below range_max")
    return calibration

"""``mukca rezero``: the zeros of joints that changed since a calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .... import recorder
from ....solver import calibration, partial, robot
from .. import OutputOptions, Terminal, argument, one_arm, option
from .tool import keep


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca rezero``."""

    calibration: Path = argument(
        "calibration.json, or its folder; of an arm never calibrated its model", "CALIBRATION"
    )
    data: Sequence[Path] = argument("placements recorded since", "DATA")
    joint: Sequence[str] = option(
        "joints whose zero changed (default: those that the evidence names)", "NAME", ()
    )
    stood: str = option(
        "placement of the calibration whose base still stands where it stood; one socket is enough "
        "then, and the first joint is told, too",
        "PLACEMENT",
        "",
    )
    ball_moved: bool = option("the ball was taken off since", default=False)
    distance: float | None = option("distance of the sockets' centres in metres", "M")


def run(options: Options, terminal: Terminal) -> int:
    """Print each joint's zero, and write the calibration with the new ones."""
    options.check_out()
    found = partial.rezero(
        arm_of(options.calibration),
        recorder.read_placements(*options.data),
        options.joint,
        options.stood,
        ball_moved=options.ball_moved,
        distance=options.distance,
    )
    keep(found, options, terminal)
    if options.out is not None and found.changed:
        terminal.say("Set the zeros in the robot instead, or load these: one of both, never both.")
    told = {one.joint: one.told for one in found.joints}
    if found.differs or not found.decided:
        return 3
    return 0 if all(told[joint] for joint in options.joint) and any(told.values()) else 3


def arm_of(file: Path) -> "calibration.Calibration | robot.Robot":
    """Return a calibration by its file or folder, or a nominal robot by its name or URDF."""
    if str(file) in robot.shipped_robots() or file.suffix == ".urdf":
        return robot.load_robot(file)
    return calibration.load_calibration(one_arm(file))

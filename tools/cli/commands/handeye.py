"""``mukca handeye``: where a camera is, on a calibrated arm or beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....solver.partial import Camera
from ....solver.results import refuse_existing
from .. import OutputOptions, Terminal, argument, option
from .tool import keep


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca handeye``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    data: Sequence[Path] = argument("poses.csv, or folders that hold one", "POSES.csv")
    camera: Camera = option("the camera is on the arm, or beside it", default=...)
    name: str = option("name of the camera's link", "LINK", "camera")


def run(options: Options, terminal: Terminal) -> int:
    """Print the camera's pose, and write the calibration with its link."""
    from ....recorder import read_placements
    from ....solver.calibration import load_calibration
    from ....solver.partial import handeye

    if options.out is not None:
        refuse_existing(options.out, force=options.force)
    calibration = load_calibration(options.calibration)
    found = handeye(calibration, read_placements(*options.data), options.camera, options.name)
    keep(found, options, terminal)
    return 0

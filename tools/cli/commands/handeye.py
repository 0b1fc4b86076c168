"""``mukca handeye``: where a camera is, on a calibrated arm or beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....solver.partial import Camera
from ....solver.results import refuse_existing
from .. import OutputOptions, Terminal, argument, option


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
    terminal.say(*found.text)
    outputs: dict[str, str] = {}
    if options.out is not None:
        outputs = found.save(options.out, force=options.force)
        terminal.say(*(f"Wrote {file}" for file in outputs.values()))
    else:
        terminal.say(f"Nothing was written; add --out DIR for a URDF with the link {options.name}.")
    terminal.emit({**found.as_dict(), "outputs": outputs})
    return 0

"""Tables of other programs as recordings, which stand beside the results made of them."""

from dataclasses import replace
from pathlib import Path

from ....recorder import Placement, own_files
from ....solver import results
from ....solver.identification import data
from ....solver.identification.robot import Robot
from .. import Terminal


def kept(
    placement: Placement,
    robot: Robot,
    out: Path,
    terminal: Terminal,
) -> Placement:
    """Return a placement; of a table as the recording that is written beside the results."""
    if not placement.is_table:
        return placement
    placement = placement.for_joints(robot.joint_names)
    data.measure(placement, robot)  # what is refused is not written
    folder = out / "recordings" / placement.name
    files = results.write_files(folder, own_files(placement)).values()
    terminal.say(*(f"Wrote {file}, what was read of the table" for file in files))
    return replace(placement, files=tuple(files), is_table=False)

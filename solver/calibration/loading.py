"""Calibrations read from files: of one robot, or of several that were calibrated together."""

from pathlib import Path
from typing import Any

from ..data import IDENTITY, Pose
from ..results import ARMS_FORMAT, ArmsDocument, format_of, read
from ..robot import Origin
from .calibration import Calibration
from .multi_robot_calibration import MultiRobotCalibration


def calibration_files(file: str | Path) -> dict[str, Path]:
    """Return the ``calibration.json`` of each robot that a file or its folder holds.

    Args:
        file: ``calibration.json``, ``arms.json``, or a folder with one of them. A single robot's
            name is empty.

    Raises:
        DocumentError: An ``arms.json`` that is damaged.
    """
    path = Path(file)
    if path.is_dir():
        one, arms = path / "calibration.json", path / "arms.json"
        path = arms if arms.is_file() and not one.is_file() else one
    if path.name != "arms.json" and format_of(path) != ARMS_FORMAT:
        return {"": path}
    names = _arms(path).robots
    return {name: path.parent / name / "calibration.json" for name in names}


def load_calibration(file: str | Path) -> Calibration | Any:
    """Read what a calibration's ``save`` wrote.

    Args:
        file: ``calibration.json``, or ``arms.json`` of several robots, or a folder with one.

    Returns:
        A :class:`Calibration`, or of several robots a :class:`MultiRobotCalibration`: no type
        checker can know which.

    Raises:
        DocumentError: Missing, of another format, or damaged; the line names the key.
    """
    files = calibration_files(file)
    loaded = {name: Calibration.of_file(path) for name, path in files.items()}
    if "" in loaded:
        return loaded[""]
    arms = _arms(next(iter(files.values())).parents[1] / "arms.json")
    poses = {arms.robots[0]: IDENTITY}
    for name in arms.robots[1:]:
        known = arms.between[f"{arms.robots[0]}_to_{name}"]
        if known.xyz and known.rpy:
            poses[name] = Pose.of(Origin(known.xyz, known.rpy))
    return MultiRobotCalibration(loaded, arms, poses)


def _arms(file: Path) -> ArmsDocument:
    return read(file, ArmsDocument, ARMS_FORMAT, "between")

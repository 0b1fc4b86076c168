"""Calibrations read from files: of one robot, or of several that were calibrated together."""

from pathlib import Path

from .. import results
from ..identification.robot import shipped_robots
from .calibration import Calibration
from .multi_robot_calibration import MultiRobotCalibration


def calibration_files(file: str | Path) -> dict[str, Path]:
    """Return the ``calibration.json`` of each robot that a file or its folder holds.

    The file is ``calibration.json`` or ``arms.json``. A single robot's name is empty.
    """
    try:
        path = Path(file)
    except TypeError:
        raise results.DocumentError(
            f"{file!r:.60} is no path: give that of calibration.json, or of its folder"
        ) from None
    if str(file) in shipped_robots() and not path.exists():
        raise results.DocumentError(
            f"{file}: a robot's name, and there is no calibration of that name yet: calibrate it "
            f"first, by mukca solve DATA --robot {file} --out DIR, and give DIR"
        )
    if path.is_dir():
        single = path / "calibration.json"
        arms = path / "arms.json"
        path = arms if arms.is_file() and not single.is_file() else single
        folders = sorted(
            str(below.parent) for below in Path(file).glob("*/calibration.json")
        )
        if folders and not path.exists():
            names = ", ".join(folders)
            raise results.DocumentError(
                f"{file}: holds no calibration.json; name one of {names}"
            )
    if path.name != "arms.json" and results.format_of(path) != results.ARMS_FORMAT:
        return {"": path}
    names = _arms(path).robots
    return {name: path.parent / name / "calibration.json" for name in names}


def load_calibration(file: str | Path) -> Calibration:
    """Read what :meth:`.Calibration.save` wrote; :func:`load_cell` reads that of several robots.

    Args:
        file: ``calibration.json``, or its folder.

    Raises:
        DocumentError: Missing, of another format, of several robots, or damaged; the line names the
            key. Or a file beside it, such as its URDF, is edited or of another calibration.
    """
    files = calibration_files(file)
    if "" not in files:
        raise results.DocumentError(
            f"{file}: of several robots; mukca.load_cell reads them, or name the folder of one: "
            f"{', '.join(files)}"
        )
    return Calibration.of_file(files[""])


def load_cell(file: str | Path) -> MultiRobotCalibration:
    """Read what was calibrated together: :meth:`.MultiRobotCalibration.save` wrote it.

    Args:
        file: ``arms.json``, or its folder.

    Raises:
        DocumentError: As by :func:`load_calibration`, or of a single robot.
    """
    files = calibration_files(file)
    if "" in files:
        raise results.DocumentError(
            f"{file}: of a single robot; mukca.load_calibration reads it"
        )
    loaded = {name: Calibration.of_file(path) for name, path in files.items()}
    arms = _arms(next(iter(files.values())).parents[1] / "arms.json")
    return MultiRobotCalibration(loaded, arms)


def _arms(file: Path) -> results.ArmsDocument:
    arms = results.read(file, results.ArmsDocument, results.ARMS_FORMAT, "between")
    results.require_beside(file, arms.output_sha256)
    return arms

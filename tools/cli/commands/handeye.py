"""``mukca handeye``: where a camera is, on a calibrated arm or beside it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .... import recorder
from ....solver import calibration, partial
from ....solver.calibration import UsageError
from ....solver.partial import Camera
from ... import extract
from .. import OutputOptions, Terminal, argument, one_arm, option
from .tool import keep

POSES = "poses.csv"
_BOARD = (9.0, 6.0, 30.0, 21.0)


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca handeye``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    data: Sequence[Path] = argument(
        "CSV files of joints and poses, or folders of images with joints.csv", "POSES.csv"
    )
    camera: Camera = option("the camera is on the arm, or beside it", default=...)
    name: str = option("name of the camera's link", "LINK", "camera")
    near: str = option(
        "posture near which the views were taken [rad], with poses of the flange in place of "
        "joints (flange_x,flange_y,flange_z,flange_qx,..,flange_qw); as in --near=-0.3,1.2,..",
        "Q1,Q2,..",
        "",
    )
    board: tuple[float, float, float, float] = option(
        "of images: the ChArUco board's squares in a row and a column, and the sides of a square "
        "and a marker (default: the board of the documentation, 9 6 30 21)",
        ("COLUMNS", "ROWS", "MM", "MM"),
        _BOARD,
    )
    dictionary: str = option("of images: the board's markers", "NAME", "5X5_100")
    intrinsics: str = option(
        "of images: the camera, in pixels (default: found from the images)",
        "FX,FY,CX,CY[,K1,K2,P1,P2[,K3]]",
        "",
    )


def run(options: Options, terminal: Terminal) -> int:
    """Print the camera's pose, and write the calibration with its link."""
    options.check_out()
    held = calibration.load_calibration(one_arm(options.calibration))
    near = numbers(options.near, "--near", (len(held.robot.joint_names),)) or None
    views = [one for path in options.data for one in _views(path, options)]
    views = [extract.joints_of(held, one, near) for one in views]
    found = partial.handeye(held, views, options.camera, options.name)
    keep(found, options, terminal)
    return 3 if found.untold else 0


def _views(path: Path, options: Options) -> "list[recorder.Placement]":
    """Return the views of a CSV file of any name, of a folder of images, or of placements."""
    if path.is_dir() and (path / POSES).is_file():
        path = path / POSES
    if path.suffix == ".csv" and path.is_file():
        return [recorder.read_points(path, path.stem)]
    if not extract.has_images(path):
        return recorder.read_placements(path)
    columns, rows, square, marker = options.board
    board = extract.Board(int(columns), int(rows), square / 1e3, marker / 1e3, options.dictionary)
    return [
        extract.read_images(path, board, numbers(options.intrinsics, "--intrinsics", (4, 8, 9)))
    ]


def numbers(words: str, option: str, counts: Sequence[int]) -> list[float]:
    """Return numbers between commas; none for an empty word."""
    try:
        found = [float(word) for word in words.split(",") if word.strip()]
    except ValueError:
        found = [float("nan")]
    if words and (len(found) not in counts or not all(map(math.isfinite, found))):
        known = " or ".join(map(str, counts))
        raise UsageError(f"{option} {words}: give {known} numbers between commas")
    return found

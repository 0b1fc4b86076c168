"""A folder of images to views of a ChArUco board: its pose in the camera, beside joint positions.

OpenCV finds the board's corners; where the camera's matrix is not given, it is found from the same
images.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ...recorder import Placement, RecordingError, Sample, joint_columns, read_table
from ...solver.calibration import quaternion_of
from ...solver.data import turn

JOINTS = "joints.csv"
IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
FEWEST_CORNERS = 8
"""Corners from which a board's pose is told."""
FEWEST_IMAGES = 8
"""Images from which the camera's matrix is found."""


@dataclass(frozen=True)
class Board:
    """A ChArUco board; by default the one that the documentation has to print."""

    columns: int = 9
    rows: int = 6
    square: float = 0.03
    """Side of a square [m]."""
    marker: float = 0.021
    """Side of a marker [m]."""
    dictionary: str = "5X5_100"


def has_images(folder: Path) -> bool:
    """Return whether a folder holds images beside ``joints.csv``."""
    return folder.is_dir() and (folder / JOINTS).is_file()


def read_images(folder: Path, board: Board, camera: Sequence[float] = ()) -> Placement:
    """Return views of a board in a folder of images, with a row of ``joints.csv`` for each by name.

    The camera is fx, fy, cx, cy [pixel], and up to five coefficients of distortion k1, k2, p1, p2,
    k3; empty to find them from these images.

    Raises:
        RecordingError: OpenCV is not installed, images and rows differ in number, or too few of
            them show the board.
    """
    try:
        cv: Any = import_module("cv2")
    except ImportError:
        raise RecordingError(
            f"{folder}: boards are found in images by OpenCV: pip install 'mukca[camera]'"
        ) from None
    table = read_table(folder / JOINTS)
    names, scales = joint_columns(table)
    files = sorted(f for f in folder.iterdir() if f.suffix.lower() in IMAGES)
    if len(files) != len(table.rows):
        raise RecordingError(
            f"{folder}: {len(files)} images, and {len(table.rows)} rows in {JOINTS}; it needs a "
            "row for each image, in the order of their names"
        )
    found, size = _corners(cv, files, board)
    if len(found) < (1 if camera else FEWEST_IMAGES):
        raise RecordingError(
            f"{folder}: {len(found)} of {len(files)} images show a board of {board.columns} x "
            f"{board.rows} squares, {board.dictionary}; is it another (--board), or out of focus?"
        )
    said = [f"{file.name}: no board found" for i, file in enumerate(files) if i not in found]
    if camera:
        fx, fy, cx, cy, *bent = camera
        matrix, bends = (
            np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]),
            np.array(bent or [0.0] * 4),
        )
    else:
        objects, points = zip(*found.values(), strict=True)
        off, matrix, bends = cv.calibrateCamera(objects, points, size, None, None)[:3]
        shown = (*matrix[[0, 1, 0, 1], [0, 1, 2, 2]], *bends.ravel()[:5])
        numbers = ",".join(f"{value:.6g}" for value in shown)
        said.append(f"--intrinsics {numbers}: by {len(found)} images, {off:.2f} pixels off (rms)")
    samples: list[Sample] = []
    for i, (corners, pixels) in found.items():
        _, turned, (x, y, z) = cv.solvePnP(corners, pixels, matrix, bends)
        qx, qy, qz, qw = quaternion_of(turn(turned.ravel())[None])[0].tolist()
        position = tuple(a * b for a, b in zip(table.rows[i], scales, strict=True))
        point, R = (float(x[0]), float(y[0]), float(z[0])), (qx, qy, qz, qw)
        samples.append(Sample(position, 0, where=str(files[i]), point=point, orientation=R))
    views = Placement(folder.name, tuple(samples), names, files=(folder,), remarks=tuple(said))
    return replace(views, poses_of="camera")


def _corners(
    cv: Any, files: Sequence[Path], board: Board
) -> tuple[dict[int, tuple[Any, Any]], tuple[int, ...]]:
    """Return the board's corners and their pixels in each image that shows it; the images' size."""
    kind = getattr(cv.aruco, f"DICT_{board.dictionary}", None)
    if kind is None:
        raise RecordingError(f"--board: no dictionary {board.dictionary}; 4X4_50, 5X5_100, .. are")
    shape = cv.aruco.CharucoBoard(
        (board.columns, board.rows),
        board.square,
        board.marker,
        cv.aruco.getPredefinedDictionary(kind),
    )
    find = cv.aruco.CharucoDetector(shape).detectBoard
    found: dict[int, tuple[Any, Any]] = {}
    size: tuple[int, ...] = ()
    for i, file in enumerate(files):
        image = cv.imread(str(file), cv.IMREAD_GRAYSCALE)
        if image is None or (size and image.shape[::-1] != size):
            raise RecordingError(f"{file}: no image of the same size as those before")
        size = image.shape[::-1]
        corners, ids = find(image)[:2]
        if ids is not None and len(ids) >= FEWEST_CORNERS:
            found[i] = shape.matchImagePoints(corners, ids)
    return found, size

"""Views of a camera: poses of a board in images, and the joints of each.

OpenCV finds the corners of a ChArUco board in a folder of images; where the matrix of the camera is
not given, it is found from the same images.
"""

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import require_file
from ...recorder import Placement, RecordingError, Sample, Table, read_table
from ...solver.calibration import quaternion_of
from ...solver.identification.robot import turn
from .intrinsics import (
    FEWEST_IMAGES,
    fitted_camera,
    residual_of_stated,
    stated_camera,
)

JOINTS = "joints.csv"
"""In a folder of images, a row of joint positions for each."""
IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
PLAIN = "none"
"""Dictionary of a chessboard without markers."""
FEWEST_CORNERS = 8
"""Fewest corners for the pose of a board."""
SOUGHT = ("4X4_1000", "5X5_1000", "6X6_1000", "7X7_1000", "ARUCO_ORIGINAL")
"""Dictionaries whose markers are looked for where the board is not seen."""
FEWEST_MARKERS = 3
"""Fewer are seen by chance."""
MOST_PIXELS = 200_000_000
"""Pixels of an image at most: of one in a single colour, a kilobyte holds millions."""


@dataclass(frozen=True)
class Board:
    """A ChArUco board; by default the one that the documentation has to print.

    The dictionary :data:`PLAIN` stands for a plain chessboard, whose marker does not count.
    """

    columns: int = 9
    rows: int = 6
    square: float = 0.03
    """Side of a square [m]."""
    marker: float = 0.021
    """Side of a marker [m]."""
    dictionary: str = "5X5_100"


def read_images(
    folder: Path,
    board: Board,
    camera: Sequence[float] = (),
) -> Placement:
    """Return views of a board in a folder of images, with a row of ``joints.csv`` for each by name.

    The camera is fx, fy, cx, cy [pixel], and up to five coefficients of distortion k1, k2, p1, p2,
    k3; empty to find them from these images.

    Raises:
        RecordingError: OpenCV is not installed, images and rows differ in number, too few of
            them show the board, or the corners contradict the camera.
    """
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MOST_PIXELS))
    try:
        cv = import_module("cv2")
    except ImportError:
        raise RecordingError(
            f"{folder}: boards are found in images by OpenCV: pip install 'mukca[camera]'"
        ) from None
    table = read_table(folder / JOINTS)
    joints = table.joints()
    rows = table.numbers(joints, gaps=bool(table.header))
    names = table.names_of(joints)
    files = _images(folder, table)
    found, size = _corners(cv, files, board)
    minimum = 1 if camera else FEWEST_IMAGES
    if len(found) < minimum:
        raise RecordingError(
            f"{folder}: {len(found)} of {len(files)} images show a board of {board.columns} x "
            f"{board.rows} squares, {board.dictionary}; {minimum} are needed; "
            f"{_seen_instead(cv, files)}is it another (--board, --dictionary), or out of "
            "focus?"
        )
    blank = [file.name for i, file in enumerate(files) if i not in found]
    remarks = [f"{name}: no board found" for name in blank]
    views = list(found.values())
    if camera:
        matrix, distortion = stated_camera(camera)
        stated = matrix, distortion
        remark = residual_of_stated(cv, views, size, stated, folder)
    else:
        matrix, distortion, remark = fitted_camera(cv, views, size)
    remarks.append(remark)
    samples: list[Sample] = []
    for i, (corners, pixels) in found.items():
        _, vector, place = cv.solvePnP(corners, pixels, matrix, distortion)
        samples.append(_view(rows[i], files[i], vector.ravel(), place.ravel()))
    return Placement(
        folder.name,
        tuple(samples),
        names,
        files=(folder / JOINTS,),
        remarks=tuple(remarks),
        poses_of="camera",
    )


def _view(
    position: tuple[float, ...],
    file: Path,
    vector: np.ndarray,
    place: np.ndarray,
) -> Sample:
    """Return a view by the board's rotation vector and place in the camera."""
    (quaternion,) = quaternion_of(turn(vector)[None]).tolist()
    return Sample(
        position,
        socket=0,
        where=str(file),
        point=tuple(place.tolist()),
        orientation=tuple(quaternion),
    )


def _images(
    folder: Path,
    table: Table,
) -> list[Path]:
    """Return the image of each row: by a column with its name, else in the order of numbers."""
    files = [file for file in folder.iterdir() if file.suffix.lower() in IMAGES]
    images = {file.name: file for file in files}
    for column in table.columns:
        paths = [row[column.index].replace("\\", "/") for row in table.rows]
        names = [path.rpartition("/")[2] for path in paths]
        if set(names) <= set(images):
            return [images[name] for name in names]
    if len(images) != len(table.rows):
        raise RecordingError(
            f"{folder}: {len(images)} images, and {len(table.rows)} rows in {JOINTS}; it needs a "
            "row for each image, in the order of their names, or a column with these"
        )
    return [images[name] for name in sorted(images, key=_by_number)]


def _by_number(name: str) -> list[tuple[int, str]]:
    """Return what puts 2.png before 10.png."""
    parts = filter(None, re.split(r"(\d+)", name))
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _corners(
    cv: Any,
    files: Sequence[Path],
    board: Board,
) -> tuple[dict[int, tuple[Any, Any]], tuple[int, ...]]:
    """Return the board's corners and their pixels in each image that shows it; the images' size.

    Both patterns that OpenCV has drawn are tried: until version 4.6, another corner of a board with
    an even number of rows was white.
    """
    pictures: list[Any] = []
    for file in files:
        require_file(file)
        try:
            picture = cv.imread(str(file), cv.IMREAD_GRAYSCALE)
        except cv.error:
            raise RecordingError(
                f"{file}: an image has at most {MOST_PIXELS} pixels"
            ) from None
        if picture is None or (pictures and picture.shape != pictures[0].shape):
            raise RecordingError(f"{file}: no image of the same size as those before")
        pictures.append(picture)
    size = pictures[0].shape[::-1] if pictures else ()
    if board.dictionary == PLAIN:
        finders = [_plain_finder(cv, board)]
    else:
        finders = [_finder(cv, board, older) for older in (False, True)]
    seen: list[dict[int, tuple[Any, Any]]] = []
    for find in finders:
        views = enumerate(map(find, pictures))
        seen.append({i: view for i, view in views if view is not None})
    return max(seen, key=len), size


Finder = Callable[[Any], "tuple[Any, Any] | None"]
"""From a picture to the board's corners and their pixels; None where it does not show the board."""


def _plain_finder(
    cv: Any,
    board: Board,
) -> Finder:
    """Return the finder of a plain chessboard's inner corners.

    Where columns and rows are even and odd, the darker of two opposite squares comes first. Boards
    that look alike after a turn may be found turned, see :mod:`.turned_boards`.
    """
    size = board.columns - 1, board.rows - 1
    if min(size) < 3:
        raise RecordingError(
            f"--board {board.columns} {board.rows}: a plain chessboard needs 4 columns and rows"
        )
    rows, columns = np.mgrid[1 : board.rows, 1 : board.columns]
    grid = np.stack([columns, rows, 0 * rows], axis=-1)
    places = board.square * grid.reshape(-1, 1, 3)
    objects = places.astype(np.float32)
    odd = (board.columns + board.rows) % 2 == 1

    def find(picture: Any) -> tuple[Any, Any] | None:
        success, pixels = cv.findChessboardCornersSB(picture, size)
        if not success:
            return None
        corners = pixels.reshape(size[1], size[0], 2)
        first = _brightness(picture, corners[:2, :2])
        last = _brightness(picture, corners[-2:, -2:])
        turned = odd and first > last
        return objects, pixels[::-1] if turned else pixels

    return find


def _brightness(
    picture: Any,
    corners: Any,
) -> int:
    """Return the brightness of a square in its middle, by its corners, shape (2, 2, 2)."""
    u, v = corners.mean(axis=(0, 1)).astype(int)
    return picture[v, u]


def _seen_instead(
    cv: Any,
    files: Sequence[Path],
) -> str:
    """Return in words which dictionary's markers the first image shows most of; empty for none."""
    if not files:
        return ""
    picture = cv.imread(str(files[0]), cv.IMREAD_GRAYSCALE)
    counts: dict[str, int] = {}
    for name in SOUGHT:
        markers = cv.aruco.getPredefinedDictionary(getattr(cv.aruco, f"DICT_{name}"))
        ids = cv.aruco.ArucoDetector(markers).detectMarkers(picture)[1]
        counts[name] = 0 if ids is None else len(ids)
    likeliest = max(counts, key=counts.__getitem__)
    if counts[likeliest] < FEWEST_MARKERS:
        return "no marker was seen, a plain chessboard is --dictionary none; "
    return f"{files[0].name} shows {counts[likeliest]} markers of {likeliest}; "


def _finder(
    cv: Any,
    board: Board,
    older: bool,
) -> Finder:
    """Return the finder of a ChArUco board's corners, in OpenCV's older pattern or its present."""
    kind = getattr(cv.aruco, f"DICT_{board.dictionary}", None)
    if kind is None:
        raise RecordingError(
            f"--dictionary: no dictionary {board.dictionary}; 4X4_50, 5X5_100, .. are"
        )
    size = (board.columns, board.rows)
    if min(size) < 2 or not 0 < board.marker < board.square:
        raise RecordingError(
            f"--board {board.columns} {board.rows} {1e3 * board.square:g} {1e3 * board.marker:g}: "
            "give 2 columns and rows or more, and a marker (mm) that is smaller than its square"
        )
    markers = cv.aruco.getPredefinedDictionary(kind)
    if len(markers.bytesList) < board.columns * board.rows // 2:
        raise RecordingError(
            f"--dictionary {board.dictionary}: {len(markers.bytesList)} markers, and the board "
            f"has {board.columns * board.rows // 2}"
        )
    shape = cv.aruco.CharucoBoard(size, board.square, board.marker, markers)
    shape.setLegacyPattern(older)
    detector = cv.aruco.CharucoDetector(shape)

    def find(picture: Any) -> tuple[Any, Any] | None:
        corners, ids = detector.detectBoard(picture)[:2]
        enough = ids is not None and len(ids) >= FEWEST_CORNERS
        return shape.matchImagePoints(corners, ids) if enough else None

    return find

"""Views of the printed board, found in images that a known camera took of it."""

import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mukca import MukcaError
from mukca.solver.identification.robot import turn
from mukca.tools.cameras import Board, read_images

BOARD = Path(__file__).parents[3] / "docs" / "images" / "charuco.svg"
CAMERA = np.array([[620.0, 0, 318], [0, 622, 243], [0, 0, 1]])
NUMBERS = (620, 622, 318, 243)
NAMES = ("a", "b")


def printed():
    """Return the board of the documentation as printed, a cell 1.5 mm, shape (120, 180)."""
    cells = np.ones((120, 180))
    for x, y, run in re.findall(r"M(\d+) (\d+)h(\d+)v1", BOARD.read_text()):
        cells[int(y), int(x) : int(x) + int(run)] = 0.0
    return cells


def rendered(cells, T):
    """Return what the camera sees of the board at a pose, 640 x 480, four rays a pixel."""
    fine = (np.arange(2) - 0.5) / 2
    u, v = (np.arange(n)[:, None] + fine for n in (640, 480))
    x, y = np.meshgrid(u.ravel(), v.ravel())
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(CAMERA).T @ T[:3, :3]
    eye = -T[:3, :3].T @ T[:3, 3]
    at = eye[:2] - rays[..., :2] * (eye[2] / rays[..., 2])[..., None]
    column, row = np.floor(at / 0.0015).astype(int).transpose(2, 0, 1)
    inside = (column >= 0) & (column < 180) & (row >= 0) & (row < 120)
    seen = np.where(inside, cells[row.clip(0, 119), column.clip(0, 179)], 1.0)
    return 255 * seen.reshape(480, 2, 640, 2).mean(axis=(1, 3))


def poses(count):
    generator = np.random.default_rng(3)
    T = np.tile(np.eye(4), (count, 1, 1))
    for one in T:
        one[:3, :3] = turn(generator.uniform(-0.45, 0.45, 3))
        one[:3, 3] = one[:3, :3] @ [-0.135, -0.09, 0] + [0, 0, generator.uniform(0.32, 0.45)]
    return T


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    cv = pytest.importorskip("cv2", reason="the extra camera is not installed")
    folder, cells = tmp_path_factory.mktemp("images"), printed()
    for i, T in enumerate(poses(10)):
        cv.imwrite(str(folder / f"{i:02}.png"), rendered(cells, T).astype(np.uint8))
    lines = [",".join(NAMES), *(f"{0.1 * i},{-0.1 * i}" for i in range(10))]
    (folder / "joints.csv").write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(("camera", "off"), [(NUMBERS, 5e-4), ((), 5e-3)])
def test_a_board_is_where_it_was(images, camera, off):
    found = read_images(images, Board(), camera)
    points = np.array([s.point for s in found.samples])
    assert found.joint_names == NAMES and found.samples[3].position == pytest.approx((0.3, -0.3))
    assert points == pytest.approx(poses(10)[:, :3, 3], abs=off)
    said = "--intrinsics leaves the corners 0." if camera else "--intrinsics 6"
    assert any(line.startswith(said) and "pixels off" in line for line in found.remarks)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.99, 1.01, 1.1])
def test_a_camera_that_the_corners_contradict_is_refused_in_pixels(images, share):
    wrong = (share * 620, share * 622, 318, 243)
    said = r"--intrinsics leaves the corners 0\.\d+ pixels off .*, and 620.* in its place 0\.1"
    with pytest.raises(MukcaError, match=said):
        read_images(images, Board(), wrong)
    assert len(read_images(images, Board(), (621, 623, 318, 243)).samples) == 10


def test_another_board_and_missing_rows_are_told(images, tmp_path):
    with pytest.raises(
        MukcaError, match=r"0 of 10 images show a board .* 00\.png shows 27 markers of 5X5_1000"
    ):
        read_images(images, Board(dictionary="7X7_50"), NUMBERS)
    (tmp_path / "joints.csv").write_text("a\n1\n")
    with pytest.raises(MukcaError, match="0 images, and 1 rows in joints"):
        read_images(tmp_path, Board())


@pytest.mark.parametrize("column", [False, True])
def test_images_go_by_their_numbers_or_by_a_column(images, tmp_path, column):
    order = list(range(10)) if not column else [3, 1, 2, 0, 9, 8, 7, 6, 5, 4]
    for i in range(10):
        shutil.copy(images / f"{i:02}.png", tmp_path / f"view {i}.png")
    lines = [f"view {i}.png,{0.1 * i},0" if column else f"{0.1 * i},0" for i in order]
    head = "image,a,b" if column else "a,b"
    (tmp_path / "joints.csv").write_text("\n".join([head, *lines]) + "\n")
    shutil.move(tmp_path / "view 1.png", tmp_path / ("view 1.png" if column else "view 01.png"))
    found = read_images(tmp_path, Board(), NUMBERS)
    points = np.array([s.point for s in found.samples])
    assert points == pytest.approx(poses(10)[order, :3, 3], abs=5e-4)
    assert [s.position[0] for s in found.samples] == pytest.approx([0.1 * i for i in order])


def test_a_board_of_the_older_pattern_is_found(tmp_path):
    cv = pytest.importorskip("cv2", reason="the extra camera is not installed")
    markers = cv.aruco.getPredefinedDictionary(cv.aruco.DICT_5X5_100)
    board = cv.aruco.CharucoBoard((9, 6), 0.03, 0.021, markers)
    board.setLegacyPattern(True)
    cv.imwrite(str(tmp_path / "1.png"), board.generateImage((640, 480), None, 30))
    (tmp_path / "joints.csv").write_text("a,b\n0.1,0.2\n")
    assert len(read_images(tmp_path, Board(), NUMBERS).samples) == 1


@pytest.mark.parametrize(
    ("board", "said"),
    [
        (Board(square=0.021, marker=0.03), "--board 9 6 21 30: .* smaller than its square"),
        (Board(columns=1), "2 columns and rows or more"),
        (Board(columns=20, dictionary="4X4_50"), "50 markers, and the board has 60"),
        (Board(dictionary="4X4"), "no dictionary 4X4"),
        (Board(dictionary="7X7_50"), "0 of 10 images .* 8 are needed"),
    ],
)
def test_what_board_it_is_can_be_wrong(images, board, said):
    with pytest.raises(MukcaError, match=said):
        read_images(images, board)


def test_a_plain_chessboard_is_where_it_was_turned_by_half_a_turn_or_not(tmp_path):
    cv = pytest.importorskip("cv2", reason="the extra camera is not installed")
    squares = (np.indices((6, 9)).sum(axis=0) + 1) % 2 == 0
    cells = np.kron(squares, np.ones((20, 20))).astype(float)
    T = poses(6)
    half = np.array([[-1.0, 0, 0, 0.27], [0, -1, 0, 0.18], [0, 0, 1, 0], [0, 0, 0, 1]])
    T[3:] = T[3:] @ half
    for i, pose in enumerate(T):
        cv.imwrite(str(tmp_path / f"{i}.png"), rendered(cells, pose).astype(np.uint8))
    (tmp_path / "joints.csv").write_text("a\n" + "".join(f"{i}\n" for i in range(6)))
    found = read_images(tmp_path, Board(dictionary="none"), NUMBERS)
    points = np.array([s.point for s in found.samples])
    same = np.abs(points - T[:, :3, 3]).max(axis=1) < 2e-3
    other = np.abs(points - (T @ half)[:, :3, 3]).max(axis=1) < 2e-3
    assert len(points) == 6 and (same.all() or other.all())
    with pytest.raises(MukcaError, match="no marker was seen, a plain chessboard is --dictionary"):
        read_images(tmp_path, Board(), NUMBERS)


def test_the_board_says_its_size():
    assert "9 x 6, squares 30 mm, markers 21 mm, DICT_5X5_100" in BOARD.read_text()
    cells = printed()
    assert cells[:20, :20].max() == 0 and cells[:3, 20:40].min() == 1


LOOK = """
from pathlib import Path
from mukca.tools.cameras import Board, read_images
read_images(Path(), Board())
"""


def test_an_image_of_too_many_pixels_is_refused_by_its_first_bytes(tmp_path):
    """In a program of its own: OpenCV asks for the bound when it is loaded."""
    pytest.importorskip("cv2", reason="the extra camera is not installed")
    (tmp_path / "joints.csv").write_text("a,b\n0.1,0.2\n")
    (tmp_path / "one.bmp").write_bytes(
        b"BM" + struct.pack("<3I3i2H6I", 0, 0, 54, 40, 30_000, 30_000, 1, 8, *[0] * 6) + bytes(2000)
    )
    words = [sys.executable, "-c", LOOK]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert "one.bmp: an image has at most 200000000 pixels" in done.stderr

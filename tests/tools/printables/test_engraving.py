"""What is engraved can be read off the mesh, and says what the mesh measures."""

import mesh_checks
import numpy as np
import printed_parts
import pytest
from scipy import ndimage

STEP = 0.1  # of the raster [mm]
# Where a letter has strokes: top, middle, bottom, upper left and right, lower left and right.
LETTERS = {
    "1011111": "0", "1110110": "2", "1110101": "3", "0101101": "4", "1111001": "5",
    "1111011": "6", "1000101": "7", "1111111": "8", "1111101": "9", "0011111": "U",
    "1110000": "T", "0100011": "n",
}  # fmt: skip


def raster(mesh, box):
    """Return where a plate is engraved 0.6 to 1 mm deep; rows from the front."""
    x0, y0, x1, y1 = box
    x, y = np.arange(x0, x1, STEP), np.arange(y0, y1, STEP)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    depth = 8.0 - mesh_checks.height_at(mesh, points, 8.5)
    assert not ((depth > 0.01) & (depth < 0.6)).any(), "too shallow"
    return ((depth >= 0.6) & (depth <= 1.0)).reshape(len(y), len(x))


def runs(marks):
    """Return the stretches of marked places."""
    labels, _ = ndimage.label(marks)
    return [box[0] for box in ndimage.find_objects(labels)]


def read(image):
    """Read lines of seven-segment letters, from the top; O comes out as 0, I as 1."""
    lines = [image[rows] for rows in reversed(runs(image.any(axis=1)))]
    return ["".join(letter(line[:, c]) for c in runs(line.any(axis=0))) for line in lines]


def letter(glyph):
    height, width = glyph.shape
    if width * STEP < 2.5:
        return "1" if glyph[height // 2 :].any() else "."
    low, middle, high = 4, height // 2, height - 5
    left, centre, right = 4, width // 2, width - 5
    places = [(high, centre), (middle, centre), (low, centre),
              (3 * height // 4, left), (3 * height // 4, right),
              (height // 4, left), (height // 4, right)]  # fmt: skip
    return LETTERS["".join(str(int(glyph[place])) for place in places)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["default", "nearest", "long", "three", "small ball", "odd"])
def test_a_base_says_what_a_caliper_reads_on_it(name):
    base, mesh = printed_parts.BASES[name], printed_parts.base_mesh(name)
    image = raster(mesh, base.text_boxes[-1])
    assert read(image) == [f"0UT{base.outside:.2f}", f"1n{base.inside:.2f}"]
    assert ndimage.binary_opening(image, np.ones((8, 8))).sum() > 0.97 * image.sum()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["default", "three", "large ball"])
def test_the_sockets_are_numbered(name):
    base, mesh = printed_parts.BASES[name], printed_parts.base_mesh(name)
    assert [read(raster(mesh, box)) for box in base.text_boxes[:-1]] == [
        [str(socket)] for socket in range(base.sockets)
    ]


def test_a_plate_says_how_far_off_its_ball_is():
    ball, mesh = printed_parts.BALLS["iso-50-4-m6"], printed_parts.ball_mesh("iso-50-4-m6")
    edge = ball.root / 2 + 0.5
    (line,) = read(raster(mesh, (-3, -edge - 7, 10, -edge)))
    assert line == f"{ball.position[2] * 1:g}"

"""Pictures and films of the simulated arm, two models side by side, without a display."""

import importlib
import io
import os
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from ctypes.util import find_library
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ...errors import MukcaError
from .motion import ROWS_PER_SECOND, Trial
from .results import Insertion
from .runs import ExperimentRun
from .scene import HOLE_DEPTH, OPEN_TO, TABLE, Scene
from .tasks import CENTRE as HOLE
from .tasks import PAPER, figure

WIDTH, HEIGHT = 320, 240
"""Of one picture [pixels]."""
FINER = 2
"""A picture is rendered so many times larger, for smooth edges."""
FRAME = (FINER * WIDTH, FINER * HEIGHT)
LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
"""MuJoCo's name for what renders without a display, and the library's."""
TITLE = 28
"""Room for a title above it [pixels]."""
LETTERS = 18
"""Height of the title's font [pixels]."""
COLOURS = 64
"""Of an animation: shades of one light, and few things."""
LAST = 2000
"""Time for which its last picture is shown [ms]."""


class PictureError(MukcaError):
    """This machine cannot render."""


INTERVAL = 0.25
"""Of the motion from one picture to the next; it is shown at twice its speed [s]."""
ALL = ((0.33, 0.0, 0.27), 1.4, -18)
AT_HOLE = ((*HOLE.tolist(), TABLE + HOLE_DEPTH), 0.13, -25)
"""Point that a camera looks at [m], its distance [m] and elevation [degrees]."""
SCALE = WIDTH / 0.2
"""Of the paper [pixels/m]."""
LINES = ("#c4511d", "#0b63a5", "#1b7f4b", "#8a4fa3", "#b98900", "#3c8f9c")


@contextmanager
def _camera(scene: Scene) -> Generator[Callable[[np.ndarray, Any], Image.Image]]:
    """Yield a function that renders the arm at joint positions, shape (m,) [rad], from a view."""
    gl = _gl_context()
    gl.make_current()
    canvas = mujoco.MjrContext(scene.model, mujoco.mjtFontScale.mjFONTSCALE_100)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, canvas)
    drawn = mujoco.MjvScene(scene.model, maxgeom=500)
    option = mujoco.MjvOption()
    frame = mujoco.MjrRect(0, 0, *FRAME)
    everything = mujoco.mjtCatBit.mjCAT_ALL
    camera = mujoco.MjvCamera()
    camera.azimuth = OPEN_TO + 180
    pixels = np.empty((*FRAME[::-1], 3), dtype=np.uint8)

    def render(q: np.ndarray, view: Any) -> Image.Image:
        scene.show(q)
        camera.lookat, camera.distance, camera.elevation = view
        mujoco.mjv_updateScene(
            scene.model, scene.data, option, None, camera, everything, drawn
        )
        mujoco.mjr_render(frame, drawn, canvas)
        mujoco.mjr_readPixels(pixels, None, frame, canvas)
        return Image.fromarray(pixels[::-1]).reduce(FINER)

    try:
        yield render
    finally:
        canvas.free()
        gl.free()


def _gl_context() -> Any:
    """Return an OpenGL context without a display: what MUJOCO_GL says, else EGL's or OSMesa's."""
    # One process can have but one of the two, so the library is looked for first.
    installed = [name for name, file in LIBRARIES.items() if find_library(file)]
    name = os.environ.get("MUJOCO_GL") or next(iter(installed), "egl")
    try:
        return importlib.import_module(f"mujoco.{name}").GLContext(*FRAME)
    except Exception as error:  # OpenGL fails in as many ways as there are drivers
        reason = " ".join(str(error).split())
        raise PictureError(
            f"no pictures: {name} gives no OpenGL ({reason}); "
            "apt-get install libegl1, or libosmesa6"
        ) from None


def film(models: Sequence[ExperimentRun]) -> tuple[bytes, bytes]:
    """Return a PNG file of the models side by side in the end, and a GIF file from the start.

    Shown is the trial that started with the elbow farthest from where it was taught: above the arm,
    below the peg at the hole, or the lines of all trials. A machine that cannot render is a
    PictureError.
    """
    titles = [model.results.model for model in models]
    columns = map(_frames, models)
    pictures = [_side_by_side(titles, frames) for frames in zip(*columns, strict=False)]
    png = io.BytesIO()
    pictures[-1].save(png, "png", optimize=True)
    return png.getvalue(), _animation(pictures)


def _animation(pictures: Sequence[Image.Image]) -> bytes:
    """Return a GIF file of pictures, at twice the speed of the motion; the last one stays."""
    # All share the last one's colours: where nothing moves, nothing is stored.
    palette = pictures[-1].quantize(COLOURS)
    images = [
        picture.quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in pictures
    ]
    first, *later_images = images
    duration = round(1e3 * INTERVAL / 2)
    gif = io.BytesIO()
    first.save(
        gif,
        "gif",
        save_all=True,
        append_images=later_images,
        duration=[duration] * len(later_images) + [LAST],
        loop=0,
        optimize=True,
    )
    return gif.getvalue()


def _side_by_side(
    titles: Sequence[str],
    columns: Sequence[Sequence[Image.Image]],
) -> Image.Image:
    """Return two pictures of each model, one below the other, under its title."""
    size = (len(titles) * WIDTH, TITLE + 2 * HEIGHT)
    page = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(page)
    font = ImageFont.load_default(LETTERS)
    for i, (title, pictures) in enumerate(zip(titles, columns, strict=True)):
        left = i * WIDTH
        draw.text((left + 8, 3), title, fill="black", font=font)
        for row, picture in enumerate(pictures):
            page.paste(picture, (left, TITLE + row * HEIGHT))
    return page


def _frames(model: ExperimentRun) -> list[list[Image.Image]]:
    """Return a model's two pictures, moment by moment, the log's last row among them."""
    shown = max(model.trials, key=lambda trial: abs(trial.result.elbow))
    insertion = isinstance(shown.result, Insertion)
    if insertion:
        model.scene.place_hole(np.array(shown.result.hole))
    q = shown.log.q
    step = round(INTERVAL * ROWS_PER_SECOND)
    frames: list[list[Image.Image]] = []
    with _camera(model.scene) as render:
        for row in reversed(range(len(q) - 1, 0, -step)):
            arm = render(q[row], ALL)
            close = render(q[row], AT_HOLE) if insertion else _paper(model.trials, row)
            frames.append([arm, close])
    return frames


def _paper(trials: Sequence[Trial[Any]], row: int) -> Image.Image:
    """Return the paper from above, as the robot sees it, with what was drawn up to a row."""
    paper = Image.new("RGB", (WIDTH, HEIGHT), "white")
    draw = ImageDraw.Draw(paper)
    draw.line(_pixels(figure(np.linspace(0, 1, 200))), fill="#c8ccd2", width=5)
    for i, trial in enumerate(trials):
        log = trial.log
        drawn = log.during("draw")
        drawn = drawn[drawn <= row]
        touching = np.linalg.norm(log.force[drawn], axis=1) > 0
        points = log.tip[drawn[touching], :2]
        if len(points) > 1:
            draw.line(_pixels(points), fill=LINES[i % len(LINES)], width=1)
    return paper


def _pixels(points: np.ndarray) -> list[tuple[float, float]]:
    """Return points on the table, shape (N, 2) [m], in the picture: x is up and y to the left."""
    aside_and_up = (points - PAPER)[:, ::-1]
    pixels = np.array([WIDTH, HEIGHT]) / 2 - SCALE * aside_and_up
    return [(x, y) for x, y in pixels.tolist()]

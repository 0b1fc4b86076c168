"""Pictures and films of the simulated arm, two models side by side, without a display."""

import importlib
import io
import os
from collections.abc import Sequence
from ctypes.util import find_library
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw

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
LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
"""MuJoCo's name for what renders without a display, and the library's."""
TITLE = 20
"""Room for a title above it [pixels]."""
COLOURS = 64
"""Of an animation: shades of one light, and few things."""


class PictureError(MukcaError):
    """This machine cannot render."""


INTERVAL = 0.25
"""Of the motion from one picture to the next; it is shown at twice its speed [s]."""
ALL = ((0.33, 0.0, 0.27), 1.4, -18)
AT_HOLE = ((*HOLE.tolist(), TABLE + HOLE_DEPTH), 0.13, -25)
"""What a camera looks at [m], from how far [m], and from what elevation [degrees]."""
SCALE = WIDTH / 0.2
"""Of the paper [pixels/m]."""
LINES = ("#c4511d", "#0b63a5", "#1b7f4b", "#8a4fa3", "#b98900", "#3c8f9c")


class Camera:
    """Renders a scene, off screen; a context manager."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._gl = _gl_context()
        self._gl.make_current()
        model = scene.model
        self._canvas = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._canvas)
        self._drawn = mujoco.MjvScene(model, maxgeom=500)

    def __enter__(self) -> "Camera":
        return self

    def __exit__(self, *_: object) -> None:
        self._canvas.free()
        self._gl.free()

    def shot(self, q: np.ndarray, view: Any) -> Image.Image:
        """Return a picture of the arm at joint positions, shape (m,) [rad]."""
        self.scene.show(q)
        camera = mujoco.MjvCamera()
        camera.lookat, camera.distance, camera.elevation = view
        camera.azimuth = OPEN_TO + 180
        model, data, everything = self.scene.model, self.scene.data, mujoco.mjtCatBit.mjCAT_ALL
        option = mujoco.MjvOption()
        mujoco.mjv_updateScene(model, data, option, None, camera, everything, self._drawn)
        pixels = np.empty((FINER * HEIGHT, FINER * WIDTH, 3), dtype=np.uint8)
        whole = mujoco.MjrRect(0, 0, FINER * WIDTH, FINER * HEIGHT)
        mujoco.mjr_render(whole, self._drawn, self._canvas)
        mujoco.mjr_readPixels(pixels, None, whole, self._canvas)
        return Image.fromarray(pixels[::-1]).reduce(FINER)


def _gl_context() -> Any:
    """Return an OpenGL context without a display: what MUJOCO_GL says, else EGL's or OSMesa's."""
    # One process can have but one of the two, so the library is looked for first.
    installed = next((name for name, file in LIBRARIES.items() if find_library(file)), "egl")
    name = os.environ.get("MUJOCO_GL") or installed
    try:
        return importlib.import_module(f"mujoco.{name}").GLContext(FINER * WIDTH, FINER * HEIGHT)
    except Exception as error:  # OpenGL fails in as many ways as there are drivers
        raise PictureError(
            f"no pictures: {name} gives no OpenGL ({' '.join(str(error).split())}); "
            "apt-get install libegl1, or libosmesa6"
        ) from None


def panel(columns: Sequence[tuple[str, Sequence[Image.Image]]]) -> Image.Image:
    """Return pictures in columns, each under its title."""
    rows = max(len(pictures) for _, pictures in columns)
    whole = Image.new("RGB", (len(columns) * WIDTH, TITLE + rows * HEIGHT), "white")
    draw = ImageDraw.Draw(whole)
    for column, (title, pictures) in enumerate(columns):
        draw.text((column * WIDTH + 8, 4), title, fill="black")
        for row, picture in enumerate(pictures):
            whole.paste(picture, (column * WIDTH, TITLE + row * HEIGHT))
    return whole


def animation(pictures: Sequence[Image.Image], seconds: float) -> bytes:
    """Return pictures as an animated GIF file, each shown for some seconds, the last longer."""
    # All share the last one's colours: where nothing moves, nothing is stored.
    palette = pictures[-1].quantize(COLOURS)
    none = Image.Dither.NONE
    small = [picture.quantize(palette=palette, dither=none) for picture in pictures]
    shown = [round(1e3 * seconds)] * (len(small) - 1) + [2000]
    file = io.BytesIO()
    small[0].save(
        file, "gif", save_all=True, append_images=small[1:], duration=shown, loop=0, optimize=True
    )
    return file.getvalue()


def film(models: Sequence[ExperimentRun]) -> tuple[bytes, bytes]:
    """Return a PNG file of the models side by side in the end, and a GIF file from the start.

    Shown is the trial that started with the elbow farthest from where it was taught: above the arm,
    below the peg at the hole, or the lines of all trials. A machine that cannot render is a
    PictureError.
    """
    columns = [(model.results.model, _frames(model)) for model in models]
    count = min(len(frames) for _, frames in columns)
    pictures = [panel([(title, frames[i]) for title, frames in columns]) for i in range(count)]
    file = io.BytesIO()
    pictures[-1].save(file, "png", optimize=True)
    return file.getvalue(), animation(pictures, INTERVAL / 2)


def _frames(model: ExperimentRun) -> list[list[Image.Image]]:
    """Return the pictures of a model's column, moment by moment; the last row is among them."""
    shown = max(model.trials, key=lambda trial: abs(trial.result.elbow))
    insertion = isinstance(shown.result, Insertion)
    if insertion:
        model.scene.place_hole(np.array(shown.result.hole))
    q = shown.log.q
    rows = np.arange(len(q) - 1, 0, -round(INTERVAL * ROWS_PER_SECOND))[::-1]
    with Camera(model.scene) as camera:
        return [
            [
                camera.shot(q[row], ALL),
                camera.shot(q[row], AT_HOLE) if insertion else _paper(model.trials, row),
            ]
            for row in rows.tolist()
        ]


def _paper(trials: Sequence[Trial[Any]], row: int) -> Image.Image:
    """Return the paper from above, as the robot sees it, with what was drawn up to a row."""
    paper = Image.new("RGB", (WIDTH, HEIGHT), "white")
    draw = ImageDraw.Draw(paper)
    draw.line(_pixels(figure(np.linspace(0, 1, 200))), fill="#c8ccd2", width=5)
    for i, trial in enumerate(trials):
        drawn = trial.log.during("draw")
        drawn = drawn[drawn <= row]
        touching = np.linalg.norm(trial.log.force[drawn], axis=1) > 0
        points = trial.log.tip[drawn[touching], :2]
        if len(points) > 1:
            draw.line(_pixels(points), fill=LINES[i % len(LINES)], width=1)
    return paper


def _pixels(points: np.ndarray) -> list[tuple[float, float]]:
    """Return points on the table, shape (N, 2) [m], in the picture: x is up and y to the left."""
    across = WIDTH / 2 - SCALE * (points[:, 1] - PAPER[1])
    down = HEIGHT / 2 - SCALE * (points[:, 0] - PAPER[0])
    return list(zip(across.tolist(), down.tolist(), strict=True))

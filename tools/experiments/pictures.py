"""Pictures of the simulated arm, rendered by MuJoCo without a display."""

# MuJoCo's types are partial, and OpenGL has none.

import importlib
import io
import os
from collections.abc import Sequence
from ctypes.util import find_library
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw

from ...errors import MukcaError
from .scene import Scene

__all__ = ["HEIGHT", "WIDTH", "Camera", "PictureError", "View", "animation", "panel", "png"]

WIDTH, HEIGHT = 320, 240
"""Of one picture [pixels]."""
LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
"""MuJoCo's name for what renders without a display, and the library's."""
TITLE = 20
"""Room for a title above it [pixels]."""
COLOURS = 64
"""Of an animation: shades of one light, and few things."""


class PictureError(MukcaError):
    """This machine cannot render."""


@dataclass(frozen=True)
class View:
    """Where a picture is taken from."""

    target: tuple[float, float, float]
    """[m]."""
    distance: float
    """[m]."""
    azimuth: float
    """[degrees]."""
    elevation: float
    """[degrees]."""


class Camera:
    """Renders a scene, off screen; a context manager.

    Raises:
        PictureError: Neither EGL nor OSMesa is there.
    """

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

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._canvas.free()
        self._gl.free()

    def shot(self, q: np.ndarray, view: View) -> Image.Image:
        """Return a picture of the arm at joint positions, shape (m,) [rad]."""
        self.scene.show(q)
        camera = mujoco.MjvCamera()
        camera.lookat[:] = view.target
        camera.distance = view.distance
        camera.azimuth, camera.elevation = view.azimuth, view.elevation
        mujoco.mjv_updateScene(
            self.scene.model,
            self.scene.data,
            mujoco.MjvOption(),
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._drawn,
        )
        pixels = np.empty((HEIGHT, WIDTH, 3), dtype=np.uint8)
        whole = mujoco.MjrRect(0, 0, WIDTH, HEIGHT)
        mujoco.mjr_render(whole, self._drawn, self._canvas)
        mujoco.mjr_readPixels(pixels, None, whole, self._canvas)
        return Image.fromarray(pixels[::-1])


def _gl_context() -> Any:
    """Return an OpenGL context without a display: what MUJOCO_GL says, else EGL's or OSMesa's.

    One process can have but one of the two, so the library is looked for first.
    """
    installed = next((name for name, file in LIBRARIES.items() if find_library(file)), "egl")
    name = os.environ.get("MUJOCO_GL") or installed
    try:
        return importlib.import_module(f"mujoco.{name}").GLContext(WIDTH, HEIGHT)
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


def png(picture: Image.Image) -> bytes:
    """Return a picture as a PNG file."""
    file = io.BytesIO()
    picture.save(file, "png", optimize=True)
    return file.getvalue()


def animation(pictures: Sequence[Image.Image], seconds: float) -> bytes:
    """Return pictures as an animated GIF file, each shown for some seconds, the last longer.

    All share the last one's colours: where nothing moves, nothing is stored.
    """
    palette = pictures[-1].quantize(COLOURS)
    none = Image.Dither.NONE
    small = [picture.quantize(palette=palette, dither=none) for picture in pictures]
    shown = [round(1e3 * seconds)] * (len(small) - 1) + [2000]
    file = io.BytesIO()
    small[0].save(
        file, "gif", save_all=True, append_images=small[1:], duration=shown, loop=0, optimize=True
    )
    return file.getvalue()

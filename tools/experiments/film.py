"""Two models side by side: the last picture of a trial, and all of it as an animation."""

# Pillow's types are partial.

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from .attempt import ExperimentRun
from .cell import TABLE
from .drawing import CENTRE as PAPER
from .drawing import Retracing, figure
from .insertion import CENTRE as HOLE
from .insertion import Trial
from .looks import OPEN_TO
from .motion import ROWS_PER_SECOND
from .pictures import HEIGHT, WIDTH, Camera, View, animation, panel, png
from .scene import HOLE_DEPTH

INTERVAL = 0.25
"""Of the motion from one picture to the next; it is shown at twice its speed [s]."""
ALL = View((0.33, 0.0, 0.27), 1.4, OPEN_TO + 180, -18)
AT_HOLE = View((*HOLE, TABLE + HOLE_DEPTH), 0.13, OPEN_TO + 180, -25)
SCALE = WIDTH / 0.2
"""Of the paper [pixels/m]."""
LINES = ("#c4511d", "#0b63a5", "#1b7f4b", "#8a4fa3", "#b98900", "#3c8f9c")


@dataclass(frozen=True)
class Film:
    """What a user looks at."""

    picture: bytes
    """A PNG file."""
    animation: bytes
    """A GIF file."""


def most_turned(trials: Sequence[Trial | Retracing]) -> int:
    """Return which trial started with the elbow farthest from where it was taught."""
    return int(np.argmax([abs(trial.elbow) for trial in trials]))


def film(models: Sequence[ExperimentRun]) -> Film:
    """Show the models' trial of :func:`most_turned`, side by side.

    Above is the arm; below the peg at the hole, or the paper with the lines of all trials.

    Raises:
        PictureError: This machine cannot render.
    """
    columns = [(model.model, _frames(model)) for model in models]
    count = min(len(frames) for _, frames in columns)
    pictures = [panel([(title, frames[i]) for title, frames in columns]) for i in range(count)]
    return Film(png(pictures[-1]), animation(pictures, INTERVAL / 2))


def _frames(model: ExperimentRun) -> list[list[Image.Image]]:
    """Return the pictures of a model's column, moment by moment; the last row is among them."""
    shown = model.trials[most_turned(model.trials)]
    insertion = isinstance(shown, Trial)
    if insertion:
        model.scene.place_hole(shown.hole)
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


def _paper(trials: Sequence[Trial | Retracing], row: int) -> Image.Image:
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

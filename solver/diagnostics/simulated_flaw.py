"""A flaw of a simulated arm: the columns of its explanation, made as large as its size says."""

import numpy as np

from ...errors import MukcaError
from ..identification.data import Measurement
from ..identification.robot import Robot
from .hypotheses import FLAWS
from .robust_fit import RigidModel
from .scene_fit import Given, scene_of


class FlawError(MukcaError):
    """The recordings can have no such flaw."""


def shift_by(
    robot: Robot,
    measured: Measurement,
    flaw: str,
    size: float,
    generator: np.random.Generator,
) -> np.ndarray:
    """Return by how much a flaw moves the balls as they were recorded, shape (N, 3) [m].

    Of several joints it takes one amid the chain; what is free besides is random.

    Args:
        robot: The robot that recorded.
        measured: Its recording.
        flaw: A word of :data:`.FLAWS`.
        size: How large the flaw is [m, rad, share]: at the ball at most, or its unknowns.
        generator: Source of what is free.

    Raises:
        FlawError: The recordings can have no such flaw.
    """
    scene = scene_of(RigidModel(robot), [measured], Given(), None)
    for kind in FLAWS[flaw]:
        for block in kind.blocks(scene):
            amid = block.columns[len(block.parameters) // 2]
            direction: np.ndarray = generator.normal(size=block.unknowns)
            change = amid @ (direction / np.linalg.norm(direction))
            shifts = scene.in_rows(block.rows, change)[scene.all_samples].reshape(-1, 3)
            largest = float(np.linalg.norm(shifts, axis=1).max())
            shifts = size / (largest if kind.at_ball else 1.0) * shifts
            return measured.as_recorded(shifts)
    raise FlawError(f"fault {flaw!r}: these recordings can have none")

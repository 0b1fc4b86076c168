"""The models that a controller is given: nominal, calibrated, true, or a file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...recorder.dataset import Placement
from ...solver.calibration import fit_by_auto
from ...solver.data import measure
from ...solver.robot import ModelError, Robot, choose_parameters
from ..simulation import Base, record
from .scene import urdf_of

WORDS = ("nominal", "calibrated", "true")
SEAT_NOISE = 5e-5
"""How well the ball sits, standard deviation per axis [m]."""
ALONG_X, ALONG_Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
PLACEMENTS = {
    "front": ((0.5, 0.0, 0.1), ALONG_Y),
    "left": ((0.35, 0.4, 0.1), ALONG_Y),
    "right": ((0.35, -0.4, 0.1), ALONG_Y),
    "far": ((0.6, 0.0, 0.1), ALONG_X),
}
"""Where the socket base stands, and the direction from socket 0 to socket 1."""


def record_placements(arm: Robot, seed: int) -> list[Placement]:
    """Return four placements recorded with an arm, 30 configurations in each socket."""
    generator = np.random.default_rng([seed, 2])
    bases = [Base(name, np.array(p), np.array(u)) for name, (p, u) in PLACEMENTS.items()]
    return [record(arm, base, generator, noise=SEAT_NOISE) for base in bases]


def calibrated_urdf(nominal: Robot, placements: Sequence[Placement]) -> bytes:
    """Return the URDF that ``mukca solve`` exports from these placements."""
    # In the order of their names, as solve reads them from a folder.
    in_order = sorted(placements, key=lambda placement: placement.name)
    train = [measure(placement, nominal) for placement in in_order]
    return fit_by_auto(nominal, choose_parameters(nominal), train).calibrated.urdf()


def model_urdf(word: str, nominal: Robot, arm: Robot, seed: int) -> bytes:
    """Return the text of a model.

    Args:
        word: ``nominal``; ``calibrated`` from recordings made now; ``true``; or a URDF file.
        nominal: The arm's nominal model.
        arm: The arm as it truly is.
        seed: Of the recordings.

    Raises:
        ModelError: The file cannot be read.
    """
    if word == "nominal":
        return nominal.text.data
    if word == "calibrated":
        return calibrated_urdf(nominal, record_placements(arm, seed))
    if word == "true":
        return urdf_of(arm)
    try:
        return Path(word).read_bytes()
    except OSError as error:
        words = ", ".join(WORDS)
        reason = error.strerror or "cannot be read"
        raise ModelError(f"model {word!r}: {reason}; give a URDF file, or {words}") from None

"""The posterior as ``calibration.json`` keeps it; :mod:`.earlier` reads it back."""

import base64
import zlib
from itertools import chain

import numpy as np

from .. import results
from ..identification.data import RobotRecordings, as_point
from ..identification.inference import FitPosterior
from ..identification.model import submatrix


def stored_posterior(
    posterior: FitPosterior, recordings: RobotRecordings, *, alone: bool
) -> results.StoredPosterior | None:
    """Return what a robot's file keeps of a posterior: of its unknowns, frames, and sockets.

    Of several robots no frame is kept; None where an instrument measured in one.
    """
    if not alone and (posterior.data.sockets < 0).any():
        return None
    arm = posterior.arm
    covariance = posterior.covariance if alone else arm.covariance
    size = arm.model.size
    first = len(covariance) - arm.centres.size
    labels = chain.from_iterable(m.labels for m in recordings.measurements)
    indices = [arm.data.labels.index(name) for name in labels]
    begins = first + 3 * np.array(indices, dtype=int)
    of_centres = (begins[:, None] + np.arange(3)).ravel()
    rows = np.r_[: arm.model.scalars, size:first, of_centres]  # none of the curves
    noises = {
        kind: (noise.space, noise.joint, noise.nu) for kind, noise in arm.noises.items()
    }
    places = tuple(map(as_point, arm.centres[indices]))
    text = _packed(submatrix(covariance, rows))
    return results.StoredPosterior(covariance=text, noises=noises, centres=places)


def _packed(matrix: np.ndarray) -> str:
    """Return a symmetric matrix as text."""
    triangle = matrix[np.tril_indices(len(matrix))].astype("<f8")
    return base64.b64encode(zlib.compress(triangle.tobytes())).decode()

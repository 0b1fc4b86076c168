"""Intrinsics of a camera: found from views of a board, or stated and held against their corners.

Where the stated camera is right, one that is fitted to the same corners lowers the sum of squares
by chance alone, so that

    (S_stated - S_fitted) / s^2,   s^2 = S_fitted / degrees of freedom

has the distribution of chi^2 with one degree for each of fx, fy, cx and cy.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...recorder import RecordingError

FEWEST_IMAGES = 8
"""Fewest images for the matrix of the camera."""
NUMBERS = 4
"""Focal lengths and centre: fx, fy, cx, cy."""
CONTRADICTED = 25.0
"""Chi^2 of these from which corners contradict a camera: 5 of 100,000 sound ones have more."""
HARMLESS = 4e-3
"""Share of the focal length by which any of these may be wrong: 1 mm at a quarter of a metre."""

Views = Sequence[tuple[Any, Any]]
"""Corners on the board and their pixels, image by image."""


def stated_camera(numbers: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of fx, fy, cx, cy [pixel], and the coefficients of distortion."""
    fx, fy, cx, cy, *coefficients = numbers
    matrix = np.diag([fx, fy, 1.0])
    matrix[:2, 2] = cx, cy
    return matrix, np.array(coefficients or [0.0] * 4)


def fitted_camera(
    cv: Any, views: Views, size: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return the camera's matrix and distortion by views of a board, and a remark with them."""
    objects, points = zip(*views, strict=True)
    rms, matrix, distortion, *_ = cv.calibrateCamera(objects, points, size, None, None)
    words = [f"{value:.6g}" for value in (*_four(matrix), *distortion.ravel()[:5])]
    fit = f"by {len(views)} images, {rms:.2f} pixels off (rms)"
    return matrix, distortion, f"--intrinsics {','.join(words)}: {fit}"


def residual_of_stated(
    cv: Any,
    views: Views,
    size: tuple[int, ...],
    camera: tuple[np.ndarray, np.ndarray],
    where: Path,
) -> str:
    """Return a remark on how far the corners are off by a stated camera.

    Raises:
        RecordingError: The corners contradict it.
    """
    matrix, distortion = camera
    squares = sum(_squares(cv, *view, matrix, distortion) for view in views)
    objects, points = zip(*views, strict=True)
    corners = sum(map(len, points))
    rms = (squares / corners) ** 0.5
    words = f"--intrinsics leaves the corners {rms:.3f} pixels off (rms)"
    if len(views) < FEWEST_IMAGES:
        return words
    fixed = ("USE_INTRINSIC_GUESS", "FIX_K1", "FIX_K2", "FIX_K3", "FIX_TANGENT_DIST")
    flags = sum(getattr(cv, f"CALIB_{name}") for name in fixed)
    least, fitted, *_ = cv.calibrateCamera(
        objects, points, size, matrix.copy(), distortion.copy(), flags=flags
    )
    degrees = 2 * corners - 6 * len(views) - NUMBERS
    chi_square = degrees * (squares / (corners * least**2) - 1)
    errors = np.abs(_four(fitted) - _four(matrix)) / fitted[0, 0]
    if chi_square < CONTRADICTED or errors.max() < HARMLESS:
        return words
    numbers = ",".join(f"{value:.1f}" for value in _four(fitted))
    raise RecordingError(
        f"{where}: {words}, and {numbers} in its place {least:.3f}: give the camera by which these "
        "images were taken, or leave the option out to find it from them"
    )


def _four(matrix: np.ndarray) -> np.ndarray:
    """Return fx, fy, cx, cy [pixel]."""
    return matrix[[0, 1, 0, 1], [0, 1, 2, 2]]


def _squares(
    cv: Any, corners: Any, pixels: Any, matrix: np.ndarray, distortion: np.ndarray
) -> float:
    """Return the sum of squares that the best pose of a board leaves [pixel^2]."""
    _, vector, place = cv.solvePnP(corners, pixels, matrix, distortion)
    seen, _ = cv.projectPoints(corners, vector, place, matrix, distortion)
    return float(np.sum((seen.reshape(-1, 2) - pixels.reshape(-1, 2)) ** 2))

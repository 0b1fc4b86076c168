"""Several markers on one flange, as motion capture writes them: x1, y1, z1, x2, y2, z2, ..

They are one rigid body. Its middle is a place, and three markers or more have a turn besides.
"""

import re

import numpy as np

from .columns import Column
from .coordinates import AXES, MATRIX
from .tables import Table

_MARKER = re.compile(r"([xyz])_?(\d+)", re.IGNORECASE)
ROUNDS = 5
FLAT = 0.05
"""Markers whose spread across their line is a smaller share of that along it have no turn."""


def marker_columns(table: Table) -> list[Column]:
    """Return the columns of two markers or more, x, y, z of each in turn; none of fewer."""
    columns: dict[tuple[int, str], Column] = {}
    for column in table.columns:
        if match := _MARKER.fullmatch(column.name.strip()):
            columns[int(match[2]), match[1].lower()] = column
    numbers = sorted({number for number, _ in columns})
    keys = [(number, axis) for number in numbers for axis in AXES]
    is_whole = len(numbers) > 1 and set(keys) == set(columns)
    return [columns[key] for key in keys] if is_whole else []


def body_of(markers: np.ndarray) -> tuple[dict[str, np.ndarray], float]:
    """Return the place of a body of K markers, shape (N, K, 3) [m], its turn, and their misfit [m].

    A row that lacks a marker has none. The shape of the body is the mean of all rows, each turned
    back by the rotation that brings the shape closest to it (Kabsch, 1976). The misfit is a root
    mean square.
    """
    whole = np.all(np.isfinite(markers), axis=(1, 2))
    middles = np.where(whole[:, None], markers.mean(axis=1), np.nan)
    numbers = {axis: middles[:, [i]] for i, axis in enumerate(AXES)}
    if not whole.any():
        return numbers, 0.0
    arms = (markers - middles[:, None])[whole]
    shape = arms[0]
    turns = np.tile(np.eye(3), (len(arms), 1, 1))
    for _ in range(ROUNDS):
        U, _, Vt = np.linalg.svd(np.einsum("nki,kj->nij", arms, shape))
        U[:, :, 2] *= np.linalg.det(U @ Vt)[:, None]
        turns = U @ Vt
        shape = np.einsum("nji,nkj->ki", turns, arms) / len(arms)
    errors: np.ndarray = arms - np.einsum("nij,kj->nki", turns, shape)
    spread = np.linalg.svd(shape, compute_uv=False)
    if spread[1] > FLAT * spread[0]:
        rows = np.full((len(markers), 9), np.nan)
        rows[whole] = (turns @ _axes(shape)).reshape(-1, 9)
        numbers |= {name: rows[:, [i]] for i, name in enumerate(MATRIX)}
    return numbers, float(np.mean(errors**2) ** 0.5)


def _axes(shape: np.ndarray) -> np.ndarray:
    """Return the axes of a body of K markers, shape (K, 3), which other tables have alike, (3, 3).

    The first points to marker 1, and the second to the first marker that is well off this line.
    """
    normals = np.cross(shape[0], shape)
    lengths = np.linalg.norm(normals, axis=1)
    z = normals[np.argmax(lengths > lengths.max() / 2)]
    axes = np.stack([shape[0], np.cross(z, shape[0]), z], axis=1)
    return axes / np.linalg.norm(axes, axis=0)

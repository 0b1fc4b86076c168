"""Several markers on one flange, as motion capture writes them: x1, y1, z1, x2, y2, z2, ..

They are one rigid body. Its middle is a place, and three markers or more have a turn besides.
"""

import re
from collections.abc import Sequence

import numpy as np

from .columns import Column
from .coordinates import AXES, MATRIX
from .tables import Table

_NUMBERED = re.compile(r"(?P<axis>[xyz])_?(?P<name>\d+)")
_NAMED = re.compile(r"(?P<name>.*\w)[\W_]+(?P<axis>[xyz])")
RIGID = 0.05
"""Scatter of a distance of two markers of a body, at most, as a share of it."""
ROUNDS = 5
FLAT = 0.05
"""Markers whose spread across their line is a smaller share of that along it have no turn."""


def marker_columns(table: Table) -> list[Column]:
    """Return the columns of several markers, x, y, z of each in turn; none of fewer.

    They are numbered, as x1, or named, as wrist X. Names must be three, which keep their distances.
    """
    columns: dict[tuple[str, str], Column] = {}
    for column in table.columns:
        name = column.name.lower()
        if match := _NUMBERED.fullmatch(name) or _NAMED.fullmatch(name):
            columns[match["name"], match["axis"]] = column
    names = list(dict.fromkeys(name for name, _ in columns))
    if all(map(str.isdecimal, names)):
        names.sort(key=int)
    keys = [(name, axis) for name in names for axis in AXES]
    if len(names) < 2 or set(keys) != set(columns):
        return []
    of_markers = [columns[key] for key in keys]
    is_body = all(map(str.isdecimal, names)) or _is_rigid(table, of_markers)
    return of_markers if is_body else []


def _is_rigid(table: Table, columns: Sequence[Column]) -> bool:
    """Return whether three points or more keep their distances from the first."""
    numbers = table.array(columns).reshape(len(table.rows), -1, 3)
    distances = np.linalg.norm(numbers[:, 1:] - numbers[:, :1], axis=2)
    spread = np.nanstd(distances, axis=0)
    return len(columns) > 6 and bool(
        (spread < RIGID * np.nanmean(distances, axis=0)).all()
    )


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

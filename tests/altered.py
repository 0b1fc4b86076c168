"""Placements as they would be otherwise, and what was found of them."""

import json
from collections import defaultdict
from dataclasses import replace

import numpy as np
from msgspec import structs

from mukca.recorder import sample_files
from mukca.solver.assessment import LIMITS
from mukca.solver.results import encode, write_files

HOLES = {
    "frontcenter": (0, 0),
    "frontleft": (0, -200),
    "frontright": (0, 175),
    "backcenter": (-150, 0),
    "backleft": (-150, -175),
    "backright": (-150, 175),
}
"""Where the bases of the recorded Panda were bolted to a table [mm]."""


def moved(placement, positions):
    """The placement as it would be with other joint positions."""
    pairs = zip(placement.samples, positions.tolist(), strict=True)
    return replace(placement, samples=tuple(replace(s, position=tuple(q)) for s, q in pairs))


def statuses(verdict):
    """The status of each row of a verdict, read from JSON or not: what is no reason passes."""
    if not isinstance(verdict, dict):
        verdict = json.loads(encode(verdict))
    rows = [*verdict["limits"], *verdict.get("reasons", ())]
    told = {row["name"]: row["status"] for row in rows}
    return defaultdict(lambda: "pass", dict.fromkeys(LIMITS, "not evaluated") | told)


def row_of(verdict, name):
    """A row of a verdict by its name."""
    return next(row for row in (*verdict.limits, *verdict.reasons) if row.name == name)


def with_efforts(placement, efforts):
    """The placement with efforts that were measured."""
    rows = zip(placement.samples, map(tuple, efforts.tolist()), strict=True)
    return replace(placement, samples=tuple(replace(s, effort=effort) for s, effort in rows))


def seats(truth, placement):
    """Where the ball sat in both sockets by the true arm, shape (2, 3)."""
    balls = truth.ball(placement.positions)
    return np.array([balls[placement.sockets == k].mean(axis=0) for k in (0, 1)])


def coefficients(found, kind):
    """Values and standard deviations of an effect's coefficients."""
    rows = [c for c in found.document.coefficients or () if c.name.split(".")[-1].startswith(kind)]
    return np.array([(c.value, c.standard_deviation) for c in rows]).T


def with_errors(summary, mean):
    """Errors as they would be with another mean, and a distance off by half a millimetre [m]."""
    large = {"mean_absolute_error": mean, "max_error": 2 * mean, "distance_error": 5e-4}
    metrics = replace(summary.calibrated, **large)
    return structs.replace(summary, calibrated=metrics, geometric=None)


def write_rows(file, rows, names=()):
    """Write rows of numbers as a CSV file, below a header where there are names."""
    lines = [",".join(names)] * bool(names) + [",".join(map(repr, row)) for row in rows]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(lines) + "\n")
    return file


def write_samples(folder, placement):
    """Write a placement as the recorder does."""
    write_files(folder, sample_files(placement))


def turned(folder, joint, angle):
    """Add an angle to a joint in all hole files of a folder [rad]."""
    for file in folder.rglob("hole_*.csv"):
        rows = [[float(x) for x in line.split(",")] for line in file.read_text().splitlines()]
        write_rows(file, [[*r[:joint], r[joint] + angle, *r[joint + 1 :]] for r in rows])

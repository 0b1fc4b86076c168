"""Residuals of all samples as a table, for whoever draws plots of his own."""

import csv
import io

from ...solver.assessment import Predictions, sample_errors
from ...solver.results import MODELS

RESIDUALS = "residuals.csv"
SAMPLE = ("placement", "role", "socket", "sample", "where", "weight in the fit")


def residual_table(predictions: Predictions) -> bytes:
    """Return a row for each sample: its ball less the mean of its socket, by each model [mm].

    The models are the maker's URDF, the full model, and calibrated.urdf where that is another.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    rows = sample_errors(predictions, most=None)
    models = MODELS[: 2 + any(row.geometric is not None for row in rows)]
    axes = [
        f"{name}_{part} [mm]" for name in models for part in ("x", "y", "z", "error")
    ]
    writer.writerow([*SAMPLE, *axes])
    for row in rows:
        placement = predictions.placements[row.placement]
        cells = [placement.name, placement.role, row.socket, row.number, row.where]
        lengths: list[float] = []
        for name in models:
            lengths += [*row.of(name), row.error(name)]
        millimetres = [f"{1e3 * length:.5f}" for length in lengths]
        writer.writerow([*cells, row.weight, *millimetres])
    return out.getvalue().encode("utf-8", "replace")

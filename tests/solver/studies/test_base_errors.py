"""Readings of one base share one error, wherever the base stands."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mukca
from mukca.solver.identification.data import SEAT_DEVIATION, Known
from mukca.solver.studies.base_errors import BaseErrors

SIZE, CALIPER = 3, 3e-5
KNOWN = (
    Known(0, 1, 0.05, CALIPER, on_base=True),
    Known(2, 3, 0.05, CALIPER, on_base=True),
    Known(4, 5, 0.1, CALIPER, on_base=True),
    Known(0, 4, 0.7, 1e-4),
)


class Model:
    """A model without effects, which only has a size."""

    size, effects = SIZE, ()


def test_what_a_fit_tells_of_a_reading_is_that_of_a_fit_with_its_error_as_an_unknown():
    generator = np.random.default_rng(0)
    n = SIZE + 18
    root = generator.normal(0, 1, (2 * n, n)) * 1e4
    centres = generator.normal(0, 0.3, (6, 3))
    U, F = np.zeros((4, n)), np.zeros((4, 3))
    errors = []
    for k, length in enumerate(KNOWN):
        offset = centres[length.second] - centres[length.first]
        along = offset / np.linalg.norm(offset)
        U[k, SIZE + 3 * length.second :][:3] = along
        U[k, SIZE + 3 * length.first :][:3] = -along
        errors.append(np.linalg.norm(offset) - length.distance)
    F[:2, 0] = F[2, 1] = CALIPER  # the last base is none of the fit's
    alone = np.array([SEAT_DEVIATION, SEAT_DEVIATION, SEAT_DEVIATION, 1e-4])
    rows = np.hstack([U, -F]) / alone[:, None]
    H = rows.T @ rows
    H[:n, :n] += root.T @ root
    H[n:, n:] += np.eye(3)
    joint = np.linalg.inv(H)
    posterior = SimpleNamespace(
        model=Model(),
        data=SimpleNamespace(known=KNOWN),
        centres=centres,
        covariance=joint[:n, :n],
        of_unknowns=joint[:SIZE, :SIZE],
    )
    bases = BaseErrors(posterior, (0.05, 0.1, 0.2))
    S_xx, S_zx = joint[:SIZE, :SIZE], joint[n:, :SIZE]
    slopes = S_zx @ np.linalg.inv(S_xx)
    assert bases.slopes == pytest.approx(slopes, rel=1e-5, abs=1e-6 * np.abs(slopes).max())
    variances = np.diag(joint[n:, n:] - slopes @ S_xx @ slopes.T)
    assert bases.variances == pytest.approx(variances, rel=1e-5)
    of_z = H[n:, n:]
    mean = np.linalg.solve(of_z, F.T @ (np.array(errors) / alone**2))
    assert bases.mean == pytest.approx(mean, rel=1e-6)


def test_held_out_readings_of_the_same_base_tell_nothing_more_of_the_size():
    robot = mukca.load_robot("panda")
    _, recorded = mukca.simulate_recordings(robot, 4, samples=10, seed=3)
    first, *others = recorded
    other_base = [replace(placement, distance=0.05 + 1e-6) for placement in others]
    same = mukca.calibrate(robot, [first], others)
    other = mukca.calibrate(robot, [first], other_base)
    widths, deviations = [], []
    for calibration in (same, other):
        now = calibration.document.better.workspace.now
        widths.append(now.high - now.low)
        rows = [row for row in calibration.errors if row.role == "test"]
        deviations.append(max(row.distance_deviation for row in rows))
    assert widths[0] > 1.1 * widths[1]
    assert deviations[0] < 0.9 * deviations[1]

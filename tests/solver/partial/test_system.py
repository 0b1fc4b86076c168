"""Errors of a linear task in units of their covariance, against the formulas with all of it."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from cameras import recorded, views

from mukca.solver.partial.camera_pose import camera_task
from mukca.solver.partial.fit import fit
from mukca.solver.partial.prior import prior_of


@pytest.fixture(scope="module", params=[1, 3], ids=["more unknowns", "more errors"])
def system(simulated, request):
    """A fit to views, with fewer errors than unknowns or with more."""
    prior = prior_of(simulated.calibration)
    rows = [views(simulated, "beside", seed=seed) for seed in range(request.param)]
    system = fit(camera_task(prior, [recorded(np.concatenate(rows))], "beside"))
    assert system.has_more_unknowns == (request.param == 1)
    return system


def covariance_of(system):
    """C, shape (R, R)."""
    noise = system.state.noise
    blocks = system.noise_blocks(noise) / system.state.weights[:, None, None]
    size = len(system.errors)
    Sigma = np.zeros((size, size))
    for i, block in enumerate(blocks):
        rows = slice(6 * i, 6 * i + 6)
        Sigma[rows, rows] = block
    G = system.slopes
    return Sigma + G @ system.task.covariance @ G.T


def test_whitened_columns_and_volume_are_those_of_the_covariance(system):
    C = covariance_of(system)
    columns = np.column_stack([system.errors, np.ones(len(C)), np.arange(len(C))])
    X, log_volume = system.whitened(columns, system.state.noise)
    expected = columns.T @ np.linalg.solve(C, columns)
    scale = np.sqrt(np.diag(expected))
    assert (X.T @ X - expected) / np.outer(scale, scale) == pytest.approx(
        np.zeros((3, 3)), abs=1e-6
    )
    assert log_volume == pytest.approx(np.linalg.slogdet(C)[1] / 2, abs=1e-4)


def test_the_change_is_the_most_probable_one(system):
    C = covariance_of(system)
    S, G = system.task.covariance, system.slopes
    expected = -S @ G.T @ np.linalg.solve(C, system.errors)
    assert system.change == pytest.approx(expected, abs=1e-7)


def test_an_error_held_out_is_that_of_all_others(system):
    C = covariance_of(system)
    errors = system.held_out()
    for i in range(len(errors)):
        rows = np.arange(6 * i, 6 * i + 6)
        others = np.setdiff1d(np.arange(len(C)), rows)
        across = np.linalg.solve(C[np.ix_(others, others)], C[np.ix_(others, rows)])
        expected = system.errors[rows] - across.T @ system.errors[others]
        assert errors[i] == pytest.approx(expected, abs=1e-8)


def test_no_matrix_holds_all_pairs_of_samples(system):
    """Of 3200 views one matrix of all pairs of errors takes 2.9 GB."""
    times = 3200 // len(system.by_joints)
    many = replace(
        system,
        state=replace(system.state, weights=np.tile(system.state.weights, times)),
        errors=np.tile(system.errors, times),
        slopes=np.tile(system.slopes, (times, 1)),
        by_joints=np.tile(system.by_joints, (times, 1, 1)),
    )
    tracemalloc.start()
    assert np.isfinite(many.change).all() and np.isfinite(many.log_evidence())
    assert np.isfinite(many.posterior_covariance(slice(3))).all()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3e8

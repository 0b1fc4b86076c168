"""Gaussians by a root, and the posterior averaged over widths: against brute force and draws."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.solver.identification.inference.width_averaging import WidthMixture, usual_width
from mukca.solver.identification.model import (
    Gaussian,
    PriorGroup,
    check,
    log_bayes_factor,
    probabilities_by_name,
)

SEEDS = st.integers(0, 2**32 - 1)


def random_gaussian(generator, n):
    units = np.logspace(-4, 2, n)
    return Gaussian(generator.normal(0, units), units[:, None] * generator.normal(0, 1, (n, n)))


@given(SEEDS)
def test_operations_are_those_of_whole_covariances(seed):
    generator = np.random.default_rng(seed)
    before = random_gaussian(generator, 6)
    A = generator.normal(0, 1, (4, 6)) / np.logspace(-4, 2, 6)
    e, S = generator.normal(0, 1, 4), before.covariance
    after = before.conditioned(A, e)
    gain = S @ A.T @ np.linalg.inv(np.eye(4) + A @ S @ A.T)
    unit = before.deviations
    assert (after.mean - before.mean + gain @ e) / unit == pytest.approx(0, abs=1e-8)
    apart = after.covariance - (S - gain @ A @ S)
    assert apart / unit / unit[:, None] == pytest.approx(0, abs=1e-8)
    back = after.conditioned(A, e + A @ (after.mean - before.mean), count=-1)
    assert (back.mean - before.mean) / unit == pytest.approx(0, abs=1e-6)
    assert (back.covariance - S) / unit / unit[:, None] == pytest.approx(0, abs=1e-6)
    again = Gaussian.of(before.mean, S).covariance
    assert again / unit / unit[:, None] == pytest.approx(S / unit / unit[:, None])
    assert before.marginal([2, 0]).covariance == pytest.approx(S[[2, 0]][:, [2, 0]])


@settings(max_examples=20)
@given(SEEDS)
def test_an_average_has_the_moments_of_draws(seed):
    generator = np.random.default_rng(seed)
    parts, shares = (
        [random_gaussian(generator, 3) for _ in range(3)],
        generator.dirichlet([2, 2, 2]),
    )
    mixture = Gaussian.averaged(parts, shares)
    z = generator.normal(0, 1, (3, 40_000))
    draws = np.concatenate(
        [
            part.mean[:, None] + part.root @ z[:, : round(40_000 * share)]
            for part, share in zip(parts, shares, strict=True)
        ],
        axis=1,
    )
    unit = mixture.deviations
    assert (draws.mean(axis=1) - mixture.mean) / unit == pytest.approx(0, abs=0.05)
    apart = np.cov(draws) - mixture.covariance
    assert apart / unit / unit[:, None] == pytest.approx(0, abs=0.1)


@given(SEEDS)
def test_what_was_seen_nearly_exactly_stays_a_covariance(seed):
    generator = np.random.default_rng(seed)
    found = random_gaussian(generator, 8)
    for noise in (1e-3, 1e-6, 1e-9):
        A = generator.normal(0, 1, (3, 8)) / np.logspace(-4, 2, 8) / noise
        found = found.conditioned(A, np.zeros(3))
        check(found.covariance)
    assert (found.deviations > 0).all()


def test_no_covariance_is_refused(monkeypatch):
    for matrix in (np.diag([1.0, -1e-3]), [[1.0, 1.0 + 1e-6], [1.0 + 1e-6, 1.0]], [[np.nan]]):
        with pytest.raises(AssertionError):
            check(np.array(matrix))
    check(np.diag([1.0, 0.0, 1e-18]))
    monkeypatch.delenv("MUKCA_CHECK_COVARIANCES")
    check(np.diag([-1.0]))


def random_problem(generator, errors=1e3):
    """Lengths that share a scale, angles, and unknowns beside them; information, and x."""
    common = 2e-3 * generator.normal(0, 1, 4)
    lengths = PriorGroup("translation", "m", np.arange(4), 1e-3, common=common)
    angles = PriorGroup("rotation", "rad", np.arange(4, 7), 5e-3)
    J = errors * generator.normal(0, 1, (6, 10))
    return (lengths, angles), J.T @ J, 1e-3 * generator.normal(0, 1, 10)


def precision(groups, widths):
    P = np.diag(np.r_[np.zeros(7), [100.0] * 3])
    for group, width in zip(groups, widths, strict=True):
        P[group.members[:, None], group.members] = group.precision(width)
    return P


@settings(max_examples=10)
@given(SEEDS)
def test_the_mixture_over_widths_is_that_of_every_posterior_by_itself(seed):
    generator = np.random.default_rng(seed)
    groups, H, peak = random_problem(generator)
    usual = [usual_width(group) for group in groups]
    x, h = 1e-3 * generator.normal(0, 1, 10), H @ peak
    at_usual = np.linalg.solve(H + precision(groups, usual), h)
    before = Gaussian.of_precision(at_usual - x, H + precision(groups, usual))
    mixture = WidthMixture(groups)
    after, widths = mixture.posterior(x, before)
    logs, means, spreads = [], [], []
    for node in mixture.widths:
        P = precision(groups, node)
        spreads.append(np.linalg.inv(H + P))
        means.append(spreads[-1] @ h)
        logs.append(np.linalg.slogdet(P)[1] - np.linalg.slogdet(H + P)[1] + h @ means[-1])
    logs = 0.5 * (np.array(logs) - np.sum(np.log(mixture.widths / usual) ** 2, axis=1))
    odds = np.exp(logs - logs.max())
    odds /= odds.sum()
    parts = [Gaussian.of(*part) for part in zip(means, spreads, strict=True)]
    expected = Gaussian.averaged(parts, odds)
    unit = expected.deviations
    assert (x + after.mean - expected.mean) / unit == pytest.approx(0, abs=1e-6)
    apart = after.covariance - expected.covariance
    assert apart / unit / unit[:, None] == pytest.approx(0, abs=1e-6)
    assert widths**2 == pytest.approx(odds @ mixture.widths**2)


@settings(max_examples=20)
@given(SEEDS, st.sampled_from([1e-3, 1.0, 1e3, 1e6, 1e9]))
def test_the_mixture_is_a_covariance_whatever_the_samples_tell(seed, errors):
    generator = np.random.default_rng(seed)
    groups, H, _ = random_problem(generator, errors)
    groups = [replace(group, width=1e-9) for group in groups]
    usual = precision(groups, [usual_width(group) for group in groups])
    before = Gaussian.of_precision(np.zeros(10), H + usual)
    after, widths = WidthMixture(groups).posterior(1e-9 * generator.normal(0, 1, 10), before)
    check(after.covariance)
    assert (widths > 1e-5).all() and (after.deviations[7:] <= 0.1 + 1e-9).all()


@given(SEEDS)
def test_the_bayes_factor_of_further_unknowns_is_that_of_the_densities(seed):
    generator = np.random.default_rng(seed)
    C, A = random_gaussian(generator, 5).covariance, generator.normal(0, 1, (5, 2))
    A *= np.logspace(-4, 2, 5)[:, None]
    r = generator.multivariate_normal(np.zeros(5), C + A @ A.T)

    def log_density(S):
        return -0.5 * (r @ np.linalg.solve(S, r) + np.linalg.slogdet(S)[1])

    M, g = A.T @ np.linalg.solve(C, A), A.T @ np.linalg.solve(C, r)
    wanted = log_density(C + A @ A.T) - log_density(C)
    assert log_bayes_factor(M, g) == pytest.approx(wanted, rel=1e-5, abs=1e-5)
    assert log_bayes_factor(np.stack([M, M]), np.stack([g, g])) == pytest.approx([wanted] * 2, 1e-5)
    alone = log_density(C + np.outer(3 * A[:, 1], 3 * A[:, 1])) - log_density(C)
    factors = log_bayes_factor(M, g, np.array([[1.0, 1.0], [0.0, 3.0]]))
    assert factors == pytest.approx([wanted, alone], rel=1e-5, abs=1e-5)
    shares = probabilities_by_name(["none", "second", "second"], np.log([1.0, 3.0, 4.0]))
    assert shares == pytest.approx({"none": 1 / 8, "second": 7 / 8})

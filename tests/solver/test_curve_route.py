"""Poses of arms with joint error curves: chosen by what curves leave unknown."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.design import CurveAnnealing, Reach, from_prior, plan_poses, workspace_of
from mukca.solver.identification.effects import curve_values, random_curves
from mukca.solver.identification.model import Noise, extend
from mukca.solver.identification.robot import choose_parameters, load_robot, workspace

pytestmark = pytest.mark.slow

ORDER = [0] * 4 + [1] * 4


@pytest.fixture(scope="module")
def known():
    model = extend(load_robot("ur10"), choose_parameters(load_robot("ur10")))
    return from_prior(model, Noise(1e-4, 0.0), 2)


@pytest.fixture(scope="module")
def pools(known):
    reach = Reach(known.model.robot)
    return {k: reach.poses(np.array([0.6, 0.05 * k, 0.1]), 80) for k in (0, 1)}


def left_unknown(known, poses, sockets):
    """Mean variances of distances after samples, with the arm's scale and without it."""
    samples = [(q[None], k) for q, k in zip(poses, sockets, strict=True)]
    state = CurveAnnealing(known, samples, {0: poses[0][None]}, [0], None)
    return both(np.diag(state.joint)[state.distances])


def both(variances):
    """Sums with the arm's scale, which is the first, and without it."""
    return np.array([variances.sum(), variances[1:].sum()])


def test_the_state_after_samples_is_that_of_the_whole_covariance(known, pools):
    state = CurveAnnealing(known, [(pools[0][:3], 0)], pools, ORDER, None)
    state.chosen = np.arange(8) + 10 + len(pools[0]) * np.array(ORDER)
    poses = [*pools[0][:3], *state.poses[state.chosen]]
    whole = left_unknown(known, poses, [0] * 3 + ORDER)
    assert state.allowed() / state.slack == pytest.approx(whole, rel=1e-6)
    less = state.updated(state.covariance(), state.rows[state.chosen[-1]], -1)
    variances = state.seen(less, state.rows[:0]).variances
    without = left_unknown(known, poses[:-1], [0] * 3 + ORDER[:-1])
    assert both(variances) == pytest.approx(without, rel=1e-6)


def test_the_pose_that_teaches_most_leaves_least_unknown(known, pools):
    taken, pool = pools[0][:3], pools[1][:12]
    state = CurveAnnealing(known, [(taken, 0)], {1: pool}, [1], None)
    state.greedy()
    left = [left_unknown(known, [*taken, q], [0, 0, 0, 1])[1] for q in pool]
    assert state.chosen[0] == np.argmin(left)


def test_curves_are_in_the_covariance_as_they_are_drawn(known):
    """Of an arm whose geometry and sockets are known."""
    fixed = replace(known, covariance=0 * known.covariance)
    q = workspace(known.model.robot, 3)
    joint = CurveAnnealing(fixed, [], {0: q}, [0], None).joint
    _, _, by = known.linearise(q)
    generator = np.random.default_rng(0)
    shown = [
        np.einsum("nij,nj->ni", by, curve_values(q, 3e-4 * random_curves(6, generator)))
        for _ in range(3000)
    ]
    drawn = np.cov(np.reshape(shown, (3000, 9)).T) * known.noise.information / 1e-8
    assert np.diag(joint)[:9] == pytest.approx(np.diag(drawn), rel=0.12)


def test_poses_for_curves_leave_less_unknown(known, pools):
    order, along = ORDER * 3, np.array([0.0, 1.0, 0.0])
    known = known.with_lengths({0: -along, 1: along}, 3e-5)
    curved = CurveAnnealing(known, [], pools, order, None).way(None)
    rigid = plan_poses(known, workspace_of(known.model, known.x), pools, order)
    assert all((pools[k] == q).all(axis=1).any() for q, k in zip(curved, order, strict=True))
    of_curves, of_rigid = (left_unknown(known, way, order) for way in (curved, rigid))
    assert (of_curves < 0.9 * of_rigid).all()

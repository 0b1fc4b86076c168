"""What samples would teach: the gain that is promised is the gain that is had."""

from itertools import pairwise

import numpy as np
import pytest

from mukca.solver.design import Reach, from_prior, plan_poses, workspace_of
from mukca.solver.identification.model import Noise, extend
from mukca.solver.identification.robot import choose_parameters, load_robot, workspace


@pytest.fixture(scope="module")
def known():
    robot = load_robot("ur5e")
    model = extend(robot, choose_parameters(robot))
    return from_prior(model, Noise(1e-4, 1e-5), 2)


@pytest.fixture(scope="module")
def where(known):
    return workspace_of(known.model, known.x, pairs=60)


def variance(known, where):
    size = known.model.size
    return float(np.sum(where.judged * (known.covariance[:size, :size] @ where.judged)))


def test_the_gain_that_is_promised_is_had(known, where):
    q = workspace(known.model.robot, 12)
    known = known.with_samples(q[:6], 0).with_samples(q[6:9], 1)
    promised = known.variance_reduction(q[9:], 1, where)[0]
    had = [1 - variance(known.with_samples(r[None], 1), where) / variance(known, where)
           for r in q[9:]]  # fmt: skip
    assert promised == pytest.approx(had, rel=1e-6)


def test_samples_and_lengths_never_make_it_worse(known, where):
    errors = [known.error(where)]
    for q in workspace(known.model.robot, 6):
        known = known.with_samples(q[None], 0).with_samples(-q[None], 1)
        errors.append(known.error(where))
    along = np.array([0.0, 1.0, 0.0])
    errors.append(known.with_lengths({0: -along, 1: along}, 3e-5).error(where))
    assert all(later < earlier for earlier, later in pairwise(errors))


def test_what_poses_are_chosen_by_leaves_the_scale_out(known, where):
    by_scale = np.zeros(known.model.size)
    lengths = [i for i, p in enumerate(known.model.parameters) if p.unit == "m"]
    by_scale[lengths] = known.model.ball.nominal[lengths]
    squares = (by_scale @ where.judged) ** 2
    assert squares[1:].sum() < 0.05 * squares.sum()


@pytest.mark.slow
def test_planned_poses_teach_as_much_as_the_best_by_a_shorter_way(known, where):
    reach, order = Reach(known.model.robot), ([0] * 4 + [1] * 4) * 2
    pools = {k: reach.poses(np.array([0.4, 0.05 * k, 0.1]), 200) for k in (0, 1)}
    planned = plan_poses(known, where, pools, order)
    greedy, best = known, []
    for k in order:
        gains = greedy.variance_reduction(pools[k], k, where)[1]
        best.append(pools[k][int(np.argmax(gains))])
        greedy = greedy.with_samples(best[-1][None], k)
    for q, k in zip(planned, order, strict=True):
        assert (pools[k] == q).all(axis=1).any()
        known = known.with_samples(q[None], k)
    assert known.error(where) < 1.1 * greedy.error(where)
    travel = [np.abs(np.diff(way, axis=0)).sum() for way in (planned, best)]
    assert travel[0] < 0.7 * travel[1]
    rest = plan_poses(known, where, pools, order[-3:], planned[-4], planned[-3:])
    assert len(rest) == 3

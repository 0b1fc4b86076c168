"""The mean of several models: between them, as uncertain as they and what they differ by."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.bayes.inference import estimate_all
from mukca.solver.bayes.model import Deflection, as_arms, extend
from mukca.solver.bayes.model.effects import EFFECTS
from mukca.solver.bayes.results.uncertainty import deviations
from mukca.solver.bayes.selection import select_all
from mukca.solver.bayes.selection.model_averaging import averaged, probabilities
from mukca.solver.data import RobotRecordings, measure, observe_all
from mukca.solver.robot import Robot, choose_parameters
from mukca.tools.simulation import Imperfection, reachable_bases, record

ELASTIC = Deflection(("compliance", "tilt"), (np.full(7, 4e-5), np.full(14, 1e-5)))


@pytest.fixture(scope="module")
def chosen(panda: Robot, true_panda: Robot):
    generator = np.random.default_rng(0)
    how = Imperfection(noise=5e-5, deflection=ELASTIC)
    (base,) = reachable_bases(true_panda, generator, 1)
    placement = record(true_panda, base, generator, samples=20, imperfection=how)
    scene = observe_all([RobotRecordings(panda, [measure(placement, panda)])])
    return select_all([(panda, choose_parameters(panda))], scene)


def test_probabilities_follow_the_evidence_and_what_is_believed_of_tilt(chosen) -> None:
    twists = replace(chosen.geometric, arms=(having(chosen, {"compliance"}),))
    tilts = replace(chosen.geometric, arms=(having(chosen, {"tilt"}),))
    both = replace(chosen.full, arms=(having(chosen, {"compliance", "tilt"}),))
    shares = np.log(probabilities([chosen.geometric, twists, tilts, both]))
    gain = chosen.full.log_evidence - chosen.geometric.log_evidence
    assert shares - shares[0] == pytest.approx([0, 0, 0, gain + np.log(4)])


def having(chosen, extensions: set[str]):
    """The posterior with those extensions and no others."""
    arm = chosen.full.arms[0]
    widths = {name: 1e-5 * (name in extensions) for name in ("compliance", "tilt")}
    assert widths.keys() <= {group.name for group in arm.groups}
    groups = tuple(replace(g, width=widths.get(g.name, g.width)) for g in arm.groups)
    return replace(arm, groups=groups)


def test_the_mean_predicts_the_mean(chosen) -> None:
    one, other = chosen.geometric, chosen.full
    mean = averaged([one, other], np.array([0.25, 0.75])).arms[0]
    data = mean.data
    points = [w.arms[0].predict(data.positions, data.torques) for w in (one, other)]
    expected = 0.25 * points[0] + 0.75 * points[1]
    found = mean.predict(data.positions, data.torques)
    apart = np.abs(points[0] - points[1]).max()
    assert np.abs(found - expected).max() < 0.01 * apart
    centres = 0.25 * one.arms[0].centres + 0.75 * other.arms[0].centres
    assert mean.centres == pytest.approx(centres)


def test_what_the_models_differ_by_is_uncertain(chosen) -> None:
    one, other = chosen.geometric.arms[0], chosen.full.arms[0]
    mean = averaged([chosen.geometric, chosen.full], np.array([0.5, 0.5])).arms[0]
    n = one.model.size
    variances = [np.diag(arm.covariance)[:n] for arm in (one, other)]
    expected = np.mean(variances, axis=0) + (one.x - other.x[:n]) ** 2 / 4
    assert np.diag(mean.covariance)[:n] == pytest.approx(expected)
    assert mean.model.extensions == other.model.extensions
    assert mean.x[n:] == pytest.approx(other.x[n:] / 2)


def test_the_model_itself_is_its_own_mean(chosen) -> None:
    mean = averaged([chosen.full], np.ones(1))
    assert mean.covariance == pytest.approx(chosen.full.covariance)
    assert mean.arms[0].x == pytest.approx(chosen.full.arms[0].x)


def test_a_harmonic_that_few_samples_do_not_show_stays_uncertain(chosen) -> None:
    kept = ("compliance", "tilt", "harmonic_1", "harmonic_2")
    model = extend(chosen.full.arms[0].model.robot, chosen.full.arms[0].model.parameters, kept)
    found = estimate_all(as_arms(model), chosen.full.scene, near=chosen.full).arms[0]
    begin = model.names.index(EFFECTS["harmonic_1"].coefficient_names(model.robot.joint_names)[0])
    assert deviations(found)[begin:].mean() > 4e-5

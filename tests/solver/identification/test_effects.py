"""Every effect of the table, by itself: its derivatives, its names, and what it does to an arm."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imagined import slopes

import mukca
from mukca.solver.calibration import SolveOptions, prior_of, problems_of
from mukca.solver.identification.data import STANDARD_LOAD, Samples, observe
from mukca.solver.identification.effects import (
    EFFECTS,
    EXTENSIONS,
    OWN,
    Display,
    Effect,
    add_effect,
)
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import Deflection, extend
from mukca.solver.identification.robot import (
    BallModel,
    angles_near,
    choose_parameters,
    load_robot,
    rotation_rpy,
    workspace,
)
from mukca.tools.simulation import Imperfection, reachable_bases, record

UNLOADED = 0.02
"""Torque under which a joint with play may rest on either side [N m]."""


@pytest.mark.parametrize("name", EFFECTS)
def test_derivatives_are_those_of_the_ball(name, panda):
    """By every coefficient, or many at once, against finite differences."""
    model = extend(panda, choose_parameters(panda), [name])
    q = workspace(panda, 4)
    samples = STANDARD_LOAD.at(panda, q)
    x = np.random.default_rng(0).uniform(0, 1e-4, model.size)
    _, derivatives, _ = model.linearise(x, samples)
    assert model.names[model.geometry :] == EFFECTS[name].coefficient_names(panda.joint_names)
    ways = np.eye(model.size)[model.geometry :]
    if len(ways) > 100:
        ways = np.random.default_rng(1).choice([-1, 0, 1], (40, len(ways))) @ ways
    for way in ways:
        ahead, behind = (model.predict(x + s * way, samples) for s in (1e-6, -1e-6))
        slope = (ahead - behind) / 2e-6
        assert derivatives @ way == pytest.approx(slope, rel=1e-6, abs=1e-6)


@pytest.fixture(scope="module")
def bases(panda):
    return reachable_bases(panda, np.random.default_rng(3), 2)


def recorded(robot, bases, name="", coefficients=(), samples=20):
    """Placements of an arm that has an effect, or none."""
    effects = Deflection((name,), (np.array(coefficients),)) if name else Deflection()
    how, hands = Imperfection(2e-5, effects), np.random.default_rng(1)
    return [record(robot, base, hands, samples=samples, imperfection=how) for base in bases]


TURN = 1e-3
"""Turn of the joint that a recorded effect turns most, its root mean square [rad]."""


def size_of(effect, robot):
    """Size of the coefficients by which an effect of any unit turns a joint by so much."""
    q = workspace(robot, 50)
    clocks = np.arange(50.0)[:, None] * np.ones(3)
    turns = effect.turns(STANDARD_LOAD.at(robot, q, clocks=clocks))
    return TURN / np.sqrt(np.mean(turns**2, axis=0)).max()


@pytest.mark.parametrize("name", EFFECTS)
def test_an_arm_that_has_an_effect_is_recorded_with_it_and_a_fit_finds_it(name, panda, bases):
    """Of the fit's effect, joints that the samples determine turn as the arm's did."""
    effect, generator = EFFECTS[name], np.random.default_rng(2)
    names = effect.coefficient_names(panda.joint_names)
    count = len(names)
    draw = effect.random or (lambda joints, source: source.uniform(0.5, 1.0, count))
    truth = size_of(effect, panda) * draw(7, generator)
    placements = recorded(panda, bases, name, truth)
    for placement, plain in zip(placements, recorded(panda, bases), strict=True):
        assert np.abs(placement.positions - plain.positions).max() > 1e-4
    if name == "curve":  # has tests of its own: it takes hundreds of samples
        return
    (problem,) = problems_of(panda, placements, (), SolveOptions().validated()).values()
    model = replace(extend(panda, choose_parameters(panda), [name]), seen=names)
    fit = estimate(model, observe(problem)).arm
    errors = fit.x[model.slices[0]] - truth
    deviations = np.sqrt(np.diag(fit.covariance))[model.slices[0]]
    shown = deviations > 0
    if effect.joint_noise is None:  # else it is believed to be what the noise shows
        assert (np.abs(errors) < 4 * deviations)[shown].all() and shown.sum() > 1
    assert np.abs(errors).min() < 0.1 * truth.min()


CREEP = Effect(
    name="creep",
    extension="creep",
    unit="rad",
    axes={"creep": OWN},
    derivatives=lambda samples: 0 * samples.q - samples.clock("index"),
    typical_shift=2e-4,
    joints="first",
)
SAG = Effect(
    name="sag",
    extension="sag",
    unit="rad/(N m)",
    axes={"sag1": 1, "sag2": 2},
    derivatives=lambda samples: -samples.moments[:, samples.q.shape[1] :],
    typical_shift=5e-4,
    joints="first",
)


@pytest.fixture
def table():
    """The table, to which a test may add effects."""
    effects = [*EFFECTS.values()]
    yield effects
    EFFECTS.clear()
    for effect in effects:
        add_effect(effect)


@pytest.mark.parametrize(("effect", "truth"), [(CREEP, [5e-5]), (SAG, [8e-5, 8e-5])])
def test_an_effect_is_one_value_and_one_line_of_the_table(effect, truth, panda, bases, table):
    """By the number of a sample, or by the load, at the first joint alone."""
    add_effect(effect)
    others = [name for name in EXTENSIONS if name != effect.extension]
    placements = recorded(panda, bases, effect.name, truth)
    calibration = mukca.calibrate(panda, placements, without=others)
    rows = calibration.document.coefficients
    assert [row.name for row in rows] == effect.coefficient_names(panda.joint_names)
    for row, value in zip(rows, truth, strict=True):
        assert row.value == pytest.approx(value, abs=4 * row.standard_deviation)
        assert row.standard_deviation < 0.2 * value


SWELL = Effect(
    name="swell",
    extension="swell",
    unit="1/rad",
    axes={"swell": OWN},
    derivatives=lambda readings: readings.q**2,
    typical_shift=1e-3,
    shown=Display(
        "per mille of a radian",
        1e3,
        usual_turn=2.0,
        usual_words="swollen gears at 81 degrees",
        heading="swollen gears",
        by_joint=True,
    ),
)


def test_an_effect_of_a_test_is_simulated_solved_and_shown_everywhere(panda, table, tmp_path):
    add_effect(SWELL)
    others = [name for name in EXTENSIONS if name != "swell"]
    assert [*EFFECTS][-2:] == ["swell", "curve"]
    sizes = {"samples": 20, "seed": 1, "swell": 3e-3}
    truth, (train, test) = mukca.simulate_recordings(panda, 2, **sizes)
    assert truth.deflection.extensions == ("swell",)
    calibration = mukca.calibrate(panda, train, test=test, without=others, repeatability_mm=0.1)
    assert calibration.calibrated.deflection.extensions == ("swell",)
    mukca.write_report(calibration, tmp_path)
    page, rows = (tmp_path / "report.html").read_text(), calibration.document.coefficients
    assert "swollen gears, per mille of a radian" in page
    assert "swollen gears at 81 degrees" in page
    largest = max(rows, key=lambda row: abs(row.value))
    assert f"{largest.name} by {1e3 * largest.value:+.2f} per mille of a radian" in page
    assert ">panda_joint3<" in page
    (group,) = [group for group in calibration.document.groups if group.name == "swell"]
    assert f"{1e3 * group.width:.4f}</span> per mille of a radian" in page
    assert "0.05 per mille of a radian<" in page  # 0.1 mm at 1 m


def test_every_effect_has_its_extension_and_its_own_names(panda):
    tried = [name for names in EXTENSIONS.values() for name in names]
    assert tried == [name for name, effect in EFFECTS.items() if effect.extension]
    names = [c for e in EFFECTS.values() for c in e.coefficient_names(panda.joint_names)]
    assert len(names) == len(set(names))


def test_backlash_rests_where_gravity_turns_it_to():
    play = Deflection(("play",), (np.array([0.01, 0.02]),))
    torques = np.array([[1.0, -1.0], [-5.0, 0.0], [UNLOADED, 0.0]])
    turned = play.true_positions(Samples(np.zeros((3, 2)), torques))
    assert turned == pytest.approx(
        np.array([[-0.01, 0.02], [0.01, 0.0], [-0.01 / 2**0.5, 0.0]]), abs=1e-5
    )


def test_a_joint_without_load_may_rest_anywhere_in_its_play():
    noise = EFFECTS["play"].joint_noise
    free, loaded = noise(np.array([[0.0, 1.0], [UNLOADED, -1.0]])).T
    assert free == pytest.approx([1.0, 0.5**0.5])
    assert (loaded < 0.2).all()


@pytest.mark.parametrize("angles", [(0.3, -0.2, 2.9), (1.5708, 1.5707963267948966, -1.5708)])
def test_angles_of_a_rotation_are_near_the_others(angles):
    R = rotation_rpy(angles).full()
    back = angles_near(R, np.array(angles) + 1e-3)
    assert rotation_rpy(back.tolist()).full() == pytest.approx(R, abs=1e-9)
    assert back == pytest.approx(angles, abs=5e-3)


def test_the_swept_volume_is_that_of_the_true_positions():
    """Else lengths and joint offsets that trade for each other would run away together."""
    robot, offsets = load_robot("so101"), np.radians([3.0, -4.0, 5.0, -2.0, 0.0])
    model = extend(robot, choose_parameters(robot), ["zero", "play"])
    q, own = workspace(robot, 20), slice(model.geometry, model.geometry + 5)
    x = np.zeros(model.size)
    x[own] = offsets
    value, slope = model.log_volume(x, q)
    true = q + offsets
    assert value == pytest.approx(model.ball.log_volume(model.ball.nominal, true)[0])
    assert slope == pytest.approx(slopes(lambda x: model.log_volume(x, q)[0], x), abs=1e-5)


def test_the_volume_of_the_swept_ball_is_that_of_its_jacobian(panda):
    """At random poses, against determinants; its slopes against finite differences."""
    model = BallModel(panda, [p.index for p in choose_parameters(panda)])
    q = np.random.default_rng(0).uniform(-1, 1, (5, 7))
    value, slope, by_joints = model.log_volume(model.nominal, q)
    J = model.linearise(model.nominal, q).by_joints
    assert value == pytest.approx(np.mean(0.5 * np.log(np.linalg.det(J @ J.transpose(0, 2, 1)))))
    by_each = slopes(lambda x: model.log_volume(x, q)[0], model.nominal)
    assert slope == pytest.approx(by_each, abs=1e-6)
    by_each = slopes(lambda q: model.log_volume(model.nominal, q)[0], q)
    assert by_joints == pytest.approx(by_each, abs=1e-6)


def test_a_robot_turns_as_a_whole_by_its_first_joint(panda):
    """Against the ball's own derivatives, at a place where the angles are large."""
    parameters = choose_parameters(panda)
    ball = BallModel(panda, [p.index for p in parameters])
    generator = np.random.default_rng(0)
    x = ball.nominal + generator.normal(0, 0.3, len(parameters))
    linear, turns = ball.linearise(x, generator.uniform(-1, 1, (3, 7))), ball.turns(x)
    first = [i for i, p in enumerate(parameters) if p.name.startswith("panda_joint1.")][3:]
    origin = ball.origins(x)[parameters[first[0]].index // 6, :3]
    for i in first:
        expected = np.cross(turns[:, i], linear.points - origin)
        assert linear.by_parameters[:, :, i] == pytest.approx(expected)
    others = np.delete(turns, first, axis=1)
    assert not others.any() and len(first) == 3


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "kept"), [("panda", True), ("xarm6", False)])
def test_tilts_of_older_files_are_no_prior_where_the_axes_have_changed(arm, kept, tmp_path):
    robot = load_robot(arm)
    _, (placement,) = mukca.simulate_recordings(robot, 1, samples=20, tilt=1e-3)
    alone = [name for name in EXTENSIONS if name != "tilt"]
    file = Path(
        mukca.calibrate(robot, placement, without=alone).save(tmp_path / "out")["calibration"]
    )
    of_today = json.loads(file.read_text())
    for age, expected in (of_today, True), (of_today | {"rotation_numbers": "rpy"}, kept):
        file.write_text(json.dumps(age))
        problems = problems_of(robot, placement, (), SolveOptions()).values()
        prior = prior_of(SolveOptions(prior=file), list(problems))
        assert any(".tilt" in name for name in prior.names) == expected

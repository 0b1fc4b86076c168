"""Points of an instrument: wherever the ball sits, and whatever the links weigh."""

import re
from dataclasses import replace

import numpy as np
import pytest
from calibrated_arm import pose_at, with_ball
from recorded import RIGID
from worlds import measured_points

import mukca
from mukca.solver.calibration.set_ups import in_own_frame
from mukca.solver.identification.data import RobotRecordings, measure, observe
from mukca.solver.identification.inference import estimate, linearise
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import choose_parameters, gravity_moments, workspace
from mukca.solver.identification.selection import set_ups

FRAME = pose_at(np.array([0.3, -1.0, 2.0]), np.array([2.0, -1.0, 0.5]))
FLANGE = "panda_link8"
BENDS = 2e-4  # [rad/(N m)]


def measured(arm, seed, name, **more):
    placement = measured_points(arm, FRAME, np.random.default_rng(seed), noise=2e-5, **more)
    return replace(placement, name=name)


def held_out(calibration):
    return calibration.errors.summary.test.calibrated.mean_absolute_error


@pytest.fixture(scope="module")
def points(true_panda):
    return measured(true_panda, 1, "train"), measured(true_panda, 2, "test")


@pytest.mark.parametrize("ball", [None, (0.09, 0.0, 0.0), (0.0, 0.2, -0.25)])
def test_a_ball_sits_where_the_points_have_it(points, panda, ball):
    by_its_place = held_out(mukca.calibrate(panda, *points, **RIGID))
    arm = mukca.load_robot("panda", flange=FLANGE, ball=ball)
    assert held_out(mukca.calibrate(arm, *points, **RIGID)) == pytest.approx(by_its_place, rel=0.02)


def test_targets_may_sit_far_apart_from_day_to_day(panda, true_panda):
    """Each set-up has a frame and a target of its own, here up to 0.25 m from each other.

    The targets turn with the arm's links, as its parameters do: the derivatives are exact.
    """
    rng, days = np.random.default_rng(4), []
    for k, place in enumerate(np.array([[0, -0.09, 0.19], [-0.03, 0.04, 0.19], [-0.04, 0, -0.04]])):
        frame = pose_at(rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3))
        day = measured_points(with_ball(true_panda, place), frame, rng, noise=2e-5, samples=40)
        day = measure(replace(day, name=f"day{k}"), panda)
        days.append(in_own_frame(day))
    data = observe(RobotRecordings(panda, days), require_scale=False)
    model = extend(panda, choose_parameters(panda))
    fit = estimate(model, data, differences=set_ups(data), average_widths=False)
    assert np.linalg.norm(fit.state.errors, axis=1).mean() < 4e-5
    objective, frames = fit.objective, fit.state.frames
    x = fit.state.x + 1e-3 * rng.standard_normal(objective.x_size)
    by_x = linearise(objective, x, frames).by_unknowns[:, :, : objective.x_size]
    for k, step in enumerate(1e-6 * np.eye(objective.x_size)):
        ahead, back = (linearise(objective, x + s, frames).places for s in (step, -step))
        assert np.allclose((ahead - back) / 2e-6, by_x[:, :, k], rtol=0, atol=1e-6)


def test_a_ball_in_sockets_must_be_known(panda):
    _, recorded = mukca.simulate_recordings(panda, 1, samples=6)
    arm = mukca.load_robot("panda", flange=FLANGE)
    with pytest.raises(mukca.MukcaError, match="in sockets, where the ball sits on 'panda_link8'"):
        mukca.calibrate(arm, recorded)


@pytest.fixture(scope="module")
def light_panda(tmp_path_factory):
    text = mukca.load_robot("panda").text.data.decode()
    file = tmp_path_factory.mktemp("light") / "panda.urdf"
    file.write_text(re.sub("<inertial>.*?</inertial>", "", text, flags=re.DOTALL))
    return mukca.load_robot(file)


def test_crude_masses_bend_an_arm_nearly_as_true_ones(true_panda, panda, light_panda):
    def bent(seed, name):
        placement = measured(true_panda, seed, name, samples=80)
        tau = gravity_moments(panda, placement.positions)[:, :7]
        return placement.with_positions(placement.positions + BENDS * tau)

    data = bent(1, "train"), bent(2, "test")
    without = ("transmission", "curves", "play")
    rigid = replace(light_panda, bodies=())
    true, crude, none = (
        held_out(mukca.calibrate(arm, *data, without=without))
        for arm in (panda, light_panda, rigid)
    )
    assert true < crude < 0.5 * none


def test_each_link_weighs_half_way_to_the_next_joint(light_panda):
    assert light_panda.masses_assumed and not mukca.load_robot("panda").masses_assumed
    bodies = light_panda.bodies
    _, second = light_panda.actuated[:2]
    assert [body.joint for body in bodies] == [
        light_panda.joints.index(joint) for joint in light_panda.actuated
    ]
    assert bodies[0].centre == pytest.approx(np.array(second.origin.xyz) / 2)
    q = workspace(light_panda, 20)
    twice = replace(light_panda, bodies=tuple(replace(b, mass=2 * b.mass) for b in bodies))
    moments = [gravity_moments(arm, q) for arm in (light_panda, twice)]
    assert moments[1] == pytest.approx(2 * moments[0])
    assert np.abs(moments[0][:, 1]).max() > 1


def test_zeros_are_looked_for_beside_a_joint_that_slides(panda, true_panda, tmp_path):
    """One lift bars no zero, nor does a joint whose angles are fixed."""
    text = panda.text.data.decode()
    name = panda.joint_names[0]
    lift = text.replace(
        f'<joint name="{name}" type="revolute">', f'<joint name="{name}" type="prismatic">'
    )
    assert lift != text
    (tmp_path / "lift.urdf").write_text(lift)
    arm = mukca.load_robot(tmp_path / "lift.urdf")
    origins = true_panda.origins.copy()
    data = measured(arm.with_origins(origins), 1, "train")
    off = np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 0.0])
    read = data.with_positions(data.positions - off)
    found = mukca.calibrate(arm, read, zeros=True, fix=["panda_joint5.rpy"], **RIGID)
    (words,) = [note for note in found.document.choices if note.startswith("joint offsets")]
    of_joint = dict(
        item.split(" ", 1) for item in words.removeprefix("joint offsets: ").split(", ")
    )
    assert float(of_joint["panda_joint3"].split()[0]) > 1.5
    assert of_joint["panda_joint1"] == of_joint["panda_joint5"] == "0.00 +- 0.00 deg"

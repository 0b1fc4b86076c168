"""What arms made of servos need: zeros that are off by degrees, and play in the gears."""

import json
from dataclasses import replace

import numpy as np
import pytest

import mukca
from mukca import calibrate
from mukca.recorder.dataset import Placement
from mukca.solver.bayes.model import Deflection, extend
from mukca.solver.bayes.model.effects.backlash import BACKLASH, UNLOADED_TORQUE
from mukca.solver.bayes.results import DECIDED, angles_near, scale, with_joint_offsets
from mukca.solver.bayes.selection.model_selection import select_model
from mukca.solver.calibration import UsageError
from mukca.solver.data import SocketAt, measure, observe
from mukca.solver.robot import (
    choose_parameters,
    gravity_torques,
    load_robot,
    rotation_rpy,
    workspace,
)
from mukca.tools.cli import main
from mukca.tools.simulation import Base, Imperfection, record

ZEROS = np.radians([3.0, -4.0, 5.0, -2.0, 0.0])
ANCHORED = Base("anchored", np.array([0.25, 0.0, 0.03]), np.array([0.7, 0.714, 0.0]), 0.15)


@pytest.fixture(scope="module")
def robot():
    return load_robot("so101")


def recorded(robot, how, samples, seed=0):
    """An arm as nominal, but that it stands at q + zero where it reads q."""
    generator = np.random.default_rng(seed)
    placement = record(robot, ANCHORED, generator, samples=samples, imperfection=how)
    moved = tuple(
        replace(sample, position=tuple(np.array(sample.position) - ZEROS))
        for sample in placement.samples
    )
    return replace(placement, samples=moved)


def selected(robot, placement, stages):
    at = [SocketAt("base", ("anchored", k), tuple(c), 1e-4) for k, c in enumerate(ANCHORED.sockets)]
    data = observe([measure(placement, robot)], robot, sockets_at=at)
    return select_model(robot, choose_parameters(robot), data, stages=stages, zeros=True)


@pytest.fixture(scope="module")
def placement(robot):
    return recorded(robot, Imperfection(noise=1e-4), 12)


@pytest.fixture(scope="module")
def found(robot, placement: Placement):
    return selected(robot, placement, ()).full


@pytest.mark.slow
def test_zeros_are_found(found):
    assert found.model.extensions == ("zero",)
    error = np.degrees(found.deflection.joint_offsets - ZEROS)
    deviation = np.degrees(np.sqrt(np.diag(found.covariance)))[found.model.geometry :]
    assert np.abs(error[:4]).max() < 0.2
    assert deviation[:4].max() < 0.1
    assert deviation[4] > 2.5, "the roll's zero is told only by where the ball is"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_play_widens_what_is_said_of_zeros(robot, seed):
    how = Imperfection(noise=3e-4, play=np.radians(0.7), resolution=2 * np.pi / 4096)
    chosen = selected(robot, recorded(robot, how, 20, seed), ("play",))
    assert chosen.full.model.extensions == ("zero", "play")
    elbow = chosen.full.deflection.coefficients[1][2]
    assert np.degrees(elbow) == pytest.approx(0.35, abs=0.12), "it always hangs on one side"
    error = (chosen.full.deflection.joint_offsets - ZEROS)[:4]
    begin = chosen.full.model.geometry
    deviation = np.sqrt(np.diag(chosen.full.covariance))[begin : begin + 4]
    assert np.abs(error / deviation).max() < 3
    assert np.degrees(np.abs(error[deviation < DECIDED])).max(initial=0) < 0.4
    assert (
        "wrist_roll" in chosen.notes[-1].rpartition(", ")[2] and "(not decided)" in chosen.notes[-1]
    )


def test_a_joint_without_load_may_rest_anywhere_in_its_play():
    free, loaded = BACKLASH.joint_noise(np.array([[0.0, 1.0], [UNLOADED_TORQUE, -1.0]])).T
    assert free == pytest.approx([1.0, 0.5**0.5])
    assert (loaded < 0.2).all()


@pytest.mark.slow
def test_a_zero_makes_no_arm_longer(found):
    value, deviation = scale(found)
    assert abs(value) < 2e-3
    assert deviation < 5e-3


@pytest.mark.slow
def test_a_urdf_holds_the_zeros(found, placement):
    positions = placement.positions
    by_origins = found.model.ball.points(with_joint_offsets(found), positions)
    assert by_origins == pytest.approx(found.predict(positions, 0 * positions), abs=1e-12)
    assert found.deflection.without_joint_offsets.extensions == ()


@pytest.mark.parametrize("angles", [(0.3, -0.2, 2.9), (1.5708, 1.5707963267948966, -1.5708)])
def test_angles_of_a_rotation_are_near_the_others(angles):
    R = rotation_rpy(angles).full()
    back = angles_near(R, np.array(angles) + 1e-3)
    assert rotation_rpy(back).full() == pytest.approx(R, abs=1e-9)
    assert back == pytest.approx(angles, abs=5e-3)


def test_play_rests_where_gravity_turns_it_to():
    play = Deflection(("play",), (np.array([0.01, 0.02]),))
    torques = np.array([[1.0, -1.0], [-5.0, 0.0], [UNLOADED_TORQUE, 0.0]])
    shift = play.true_positions(np.zeros((3, 2)), torques)
    assert shift == pytest.approx(
        np.array([[-0.01, 0.02], [0.01, 0.0], [-0.01 / 2**0.5, 0.0]]), abs=1e-5
    )


def test_a_simulated_arm_with_play_sags(robot):
    how = Imperfection(play=0.02, resolution=0.0)
    one, sagged = (
        record(robot, ANCHORED, np.random.default_rng(1), samples=6, imperfection=i).positions
        for i in (Imperfection(), how)
    )
    assert np.abs(sagged - one) == pytest.approx(0.01)
    torques = gravity_torques(robot, one)
    loaded = np.abs(torques) > 0.05
    assert loaded.sum() > 20
    assert (np.sign(sagged - one) == np.sign(torques))[loaded].all()


def test_a_simulated_encoder_has_steps(robot):
    how = Imperfection(resolution=0.01)
    read = record(robot, ANCHORED, np.random.default_rng(1), samples=3, imperfection=how).positions
    assert read / 0.01 == pytest.approx(np.round(read / 0.01))


def test_zeros_need_angles_that_are_free(robot, placement):
    with pytest.raises(UsageError, match="--zeros: elbow_flex must turn, and its angles be free"):
        calibrate(robot, placement, zeros=True, fix=["elbow_flex.yaw"])
    with pytest.raises(mukca.MukcaError, match="belongs to --method auto"):
        calibrate(robot, placement, zeros=True, method="paper")


@pytest.mark.slow
def test_check_and_crossval_know_of_zeros_as_solve_does(robot, tmp_path, capsys):
    for seed, name in enumerate("ab"):
        (tmp_path / name).mkdir()
        placement = recorded(robot, Imperfection(noise=1e-4), 12, seed)
        for k in (0, 1):
            rows = placement.positions[placement.sockets == k].tolist()
            text = "\n".join(",".join(map(str, q)) for q in rows)
            (tmp_path / name / f"hole_{k}.csv").write_text(text)
    figures = {}
    for zeros in ((), ("--zeros",)):
        words = (str(tmp_path), "--robot", "so101", "--distance", "0.15", "--json", *zeros)
        status = main(["check", *words])
        found = json.loads(capsys.readouterr().out)
        codes = {d["code"] for one in (found, *found["placements"]) for d in one["findings"]}
        assert bool(codes & {"zero", "scale"}) == (not zeros), status
        assert main(["crossval", *words, "--processes", "1"]) == 0
        figures[zeros] = json.loads(capsys.readouterr().out)["summary"]
    assert figures[("--zeros",)]["mean_absolute_error"] < figures[()]["mean_absolute_error"]


def test_the_swept_volume_is_that_of_where_the_joints_stand(robot):
    """Else lengths and zeros that trade for each other would run away together."""
    model = extend(robot, choose_parameters(robot), ("zero", "play"))
    q, zeros = workspace(robot, 20), slice(model.geometry, model.geometry + 5)
    x = np.zeros(model.size)
    x[zeros] = ZEROS
    value, slope = model.log_volume(x, q)
    assert value == pytest.approx(model.ball.log_volume(model.ball.nominal, q + ZEROS)[0])
    for i in (0, zeros.start + 1, zeros.start + 2, zeros.stop):
        step = 1e-6 * np.eye(model.size)[i]
        ahead, behind = (model.log_volume(x + s, q)[0] for s in (step, -step))
        assert slope[i] == pytest.approx((ahead - behind) / 2e-6, abs=1e-5)

"""Known truth is found again, by both optimizers, and never without having converged."""

from dataclasses import replace
from shutil import copyfile

import numpy as np
import pytest

from mukca import MukcaError
from mukca.errors import NotConverged
from mukca.recorder import read_placement
from mukca.solver.identification.data import check_distinct, evaluate, measure, socket_centres
from mukca.solver.identification.paper import build_problem, solve
from mukca.solver.identification.robot import load_robot
from mukca.solver.results import CalibratedRobot
from mukca.tools.simulation import perturb, reachable_bases, record

# One of each kind, since a fit takes seconds: seven joints, six, and five. At a pitch of 90 degrees
# roll, pitch and yaw cannot say all turns.
REPRESENTATIVE = ("panda", "iiwa14", "ur5e", "koch")


@pytest.fixture(scope="module", params=REPRESENTATIVE)
def workspace(request):
    """A robot, one truly a little different, and five places of the base in its workspace."""
    nominal = load_robot(request.param)
    generator = np.random.default_rng(3)
    arm = perturb(nominal, generator, 2e-3, 5e-3)
    return nominal, arm, reachable_bases(arm, generator, 5), generator


def fitted(nominal, measured, regularization):
    """The problem, and the arm at its minimum."""
    problem = build_problem(nominal, measured, regularization=regularization)
    x = solve(problem).x
    return problem, CalibratedRobot(nominal, problem.parameters, x, rotation_numbers="rpy")


@pytest.mark.slow
def test_without_noise_the_truth_is_found(workspace):
    nominal, arm, bases, generator = workspace
    measured = [measure(record(arm, base, generator), nominal) for base in bases]
    _, calibration = fitted(nominal, measured[:4], 1e-12)
    before = evaluate(calibration.nominal_ball(measured[4].positions), measured[4])
    after = evaluate(calibration.ball(measured[4].positions), measured[4])
    assert before.mean_absolute_error > 1e-3
    assert after.mean_absolute_error < 1e-6
    assert abs(after.distance_error) < 1e-6
    found = [socket_centres(calibration.ball(m.positions), m)[0] for m in measured]
    for i in range(5):
        for j in range(i):
            apart = np.linalg.norm(bases[i].sockets[0] - bases[j].sockets[0])
            assert np.linalg.norm(found[i] - found[j]) == pytest.approx(apart, abs=1e-6)


@pytest.mark.slow
def test_with_noise_the_held_out_error_is_the_noise(workspace):
    nominal, arm, bases, generator = workspace
    measured = [measure(record(arm, base, generator, noise=1e-4), nominal) for base in bases]
    problem, calibration = fitted(nominal, measured[:4], 1e-6)
    values = problem.model.parameters_at(arm.origins)
    truth = CalibratedRobot(nominal, problem.parameters, values, rotation_numbers="rpy")
    held_out = measured[4]
    by_noise = evaluate(truth.ball(held_out.positions), held_out).mean_absolute_error
    found = evaluate(calibration.ball(held_out.positions), held_out).mean_absolute_error
    assert found <= 1.15 * by_noise


@pytest.mark.slow
@pytest.mark.parametrize("optimizer", ["gauss-newton", "ipopt"])
def test_not_converged_is_never_a_result(session, panda, optimizer):
    problem = build_problem(panda, [measure(read_placement(session / "front"), panda)])
    with pytest.raises(NotConverged):
        solve(problem, optimizer, max_iterations=1)


def test_regularization_counts_once_per_placement(session, panda):
    measured = measure(read_placement(session / "front"), panda)
    again = replace(measured, placement=replace(measured.placement, name="again"))
    problem = build_problem(panda, [measured], regularization=1e-3)
    twice = replace(problem, training=(measured, again))
    once_x, twice_x = solve(problem).x, solve(twice).x
    assert twice_x == pytest.approx(once_x, abs=1e-9)


def test_a_socket_that_is_a_copy_of_another_is_refused(session, panda, tmp_path):
    for name in ("hole_0.csv", "hole_1.csv"):
        copyfile(session / "front/hole_0.csv", tmp_path / name)
    with pytest.raises(MukcaError, match=r"hole_0\.csv and .*hole_1\.csv are identical"):
        measure(read_placement(tmp_path), panda)
    copyfile(session / "right/hole_1.csv", tmp_path / "hole_1.csv")
    others = [measure(read_placement(session / name), panda) for name in ("left", "right")]
    check_distinct(others)
    with pytest.raises(MukcaError, match=r"right/hole_1\.csv and .*hole_1\.csv are identical"):
        check_distinct([*others, measure(read_placement(tmp_path), panda)])


def test_a_copy_in_another_order_and_rounded_is_one(session, panda):
    """As after a detour by way of a spreadsheet."""
    read = read_placement(session / "front")
    rounded = [replace(s, position=tuple(np.round(s.position, 7).tolist())) for s in read.samples]
    copy = replace(read, name="copy", files=(), samples=tuple(reversed(rounded)))
    with pytest.raises(MukcaError, match="are identical, so one is a copy"):
        check_distinct([measure(read, panda), measure(copy, panda)])

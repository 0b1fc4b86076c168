"""The inverse by blocks against the whole one, and steps that turn the robot as a whole."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.bayes.inference.arrowhead import ArrowheadMatrix
from mukca.solver.bayes.inference.hyperparameters import prune_groups
from mukca.solver.bayes.inference.normal_equations import normal_equations
from mukca.solver.bayes.inference.objective import Objective, State, build_objective
from mukca.solver.bayes.inference.state import moved, start
from mukca.solver.bayes.model import extend
from mukca.solver.data import measure, observe
from mukca.solver.robot import BallModel, Robot, choose_parameters
from mukca.tools.simulation import reachable_bases, record


def random_arrow(seed: int, sockets: int, known: int) -> tuple[ArrowheadMatrix, np.ndarray]:
    """Of 5 unknowns whose units differ, and the whole matrix."""
    generator = np.random.default_rng(seed)
    units = np.logspace(-2, 2, 5)
    roots = generator.normal(0, 1, (sockets, 3, 3))
    own, D = roots @ roots.swapaxes(1, 2) + np.eye(3), np.zeros((3 * sockets,) * 2)
    for k, block in enumerate(own):
        D[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
    root, X = generator.normal(0, 1, (5, 5)) * units, generator.normal(0, 1, (3 * sockets, 5))
    Z, B = root.T @ root, generator.normal(0, 3, (known, 5 + 3 * sockets))
    H = np.block([[Z + X.T @ D @ X, X.T @ D], [D @ X, D]]) + B.T @ B
    return ArrowheadMatrix(Z, X, own, B), H


@pytest.mark.parametrize(("sockets", "known"), [(0, 0), (1, 0), (4, 3), (3, 9)])
def test_the_inverse_by_blocks_is_the_whole_one(sockets: int, known: int) -> None:
    arrow, H = random_arrow(sockets, sockets, known)
    free = np.array([True, True, False, True, True])
    rows = np.r_[free, np.ones(3 * sockets, dtype=bool)]
    some = np.ix_(rows, rows)
    inverse, expected = arrow.inverse(free), np.zeros_like(H)
    expected[some] = np.linalg.inv(H[some])
    assert inverse.whole() == pytest.approx(expected, rel=1e-7, abs=1e-10)
    v = np.random.default_rng(9).normal(0, 1, len(H))
    assert arrow.times(v) == pytest.approx(H @ v)
    assert inverse.times(v) == pytest.approx(expected @ v, rel=1e-7, abs=1e-10)
    assert inverse.log_determinant == pytest.approx(np.linalg.slogdet(H[some])[1])
    H[:5, :5] += np.eye(5)
    assert arrow.plus(np.eye(5)).times(v) == pytest.approx(H @ v)


@pytest.fixture(scope="module")
def nominal(panda: Robot, true_panda: Robot) -> tuple[Objective, State]:
    """Before any step, when all samples are centimetres off, by no noise."""
    generator = np.random.default_rng(3)
    placements = [
        record(true_panda, base, generator, samples=6, noise=1e-4)
        for base in reachable_bases(true_panda, generator, 2)
    ]
    data = observe([measure(placement, panda) for placement in placements], panda)
    objective = build_objective(extend(panda, choose_parameters(panda)), data)
    return objective, start(objective, joint_noise=True)


def turn(objective: Objective, state: State, angle: float) -> np.ndarray:
    """The change of all unknowns, to first order, that turns robot and sockets as a whole."""
    model = objective.model.models[0]
    ball, change = model.ball, np.zeros(objective.size)
    turns = ball.turns(model.values(state.x))
    change[: model.geometry] = angle * np.linalg.pinv(turns)[:, 0]
    names = [f"{model.robot.actuated[0].name}.{axis}" for axis in "xyz"]
    origin = ball.origins(model.values(state.x))[1, :3]
    axis = np.array([angle, 0, 0])
    change[[model.names.index(name) for name in names]] = np.cross(axis, origin)
    change[objective.dense :] = np.cross(axis, state.centres).ravel()
    return change


@pytest.mark.slow
def test_no_error_is_a_reason_to_turn_the_robot_as_a_whole(nominal) -> None:
    """As the noise turns along: else a model that cannot be right turns ever farther."""
    objective, state = nominal
    assert state.noises[0].joint > 0
    normal, change = normal_equations(objective, state), turn(objective, state, 1.0)
    forces = np.abs(normal.gradient * change).sum()
    assert abs(normal.gradient @ change) < 1e-9 * forces


def test_sockets_go_along_where_the_robot_turns_far(nominal) -> None:
    objective, state = nominal
    there = moved(objective, state, turn(objective, state, 0.05))
    before, after = (np.linalg.norm(s.linear.errors, axis=1) for s in (state, there))
    assert np.abs(there.linear.points - state.linear.points).max() > 0.01
    assert after == pytest.approx(before, abs=1e-5)


def test_what_turns_a_robot_as_a_whole_is_its_first_joint(panda: Robot) -> None:
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


def test_what_is_pruned_leaves_no_trace_in_the_errors(nominal) -> None:
    """An extension that is set to zero at last must be out of the balls, too."""
    robot, data = nominal[0].model.models[0].robot, nominal[0].rows.scene.arms[0]
    model = extend(robot, choose_parameters(robot), ("harmonic_1",))
    objective = build_objective(model, data)
    change = np.zeros(objective.size)
    change[model.geometry : model.size] = 1e-4
    state = moved(objective, start(objective, joint_noise=False), change)
    *kept, group = state.groups
    state = replace(state, groups=(*kept, replace(group, width=1e-9)))
    pruned = prune_groups(objective, state)
    assert pruned.groups[-1].width == 0 and not pruned.x[model.geometry :].any()
    again = model.predict(pruned.x, data.positions, data.torques)
    assert pruned.linear.points == pytest.approx(again, abs=1e-12)

"""Sockets whose coordinates are known in a frame: a table's, or the robot's own base."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.recorder.dataset import Placement
from mukca.solver.bayes.inference import JointPosterior, Posterior, estimate_all
from mukca.solver.bayes.model import as_arms, as_scene, extend
from mukca.solver.bayes.results import unobservable, weakly_identifiable_directions
from mukca.solver.bayes.results.identifiability import UNOBSERVABLE
from mukca.solver.bayes.results.uncertainty import deviations
from mukca.solver.data import FrameError, Pose, SocketAt, measure, observe
from mukca.solver.robot import BallModel, Robot, choose_parameters, load_robot, workspace
from mukca.tools.simulation import Base, perturb, random_pose, reachable_bases, record, sockets_seen

HOME = Pose(np.eye(3), np.zeros(3))
BASES = [
    Base(name, np.array(centre), np.array([0.0, 1.0, 0.0]))
    for name, centre in (
        ("front", [0.5, 0.0, 0.1]),
        ("left", [0.35, 0.4, 0.25]),
        ("right", [0.35, -0.4, 0.1]),
    )
]


def fit(robot: Robot, placements: list[Placement], at: list[SocketAt]) -> JointPosterior:
    data = observe([measure(p, robot) for p in placements], robot, sockets_at=at)
    model = extend(robot, choose_parameters(robot))
    return estimate_all(as_arms(model), as_scene(data), joint_noise=False)


def without_distance(placements: list[Placement]) -> list[Placement]:
    return [replace(p, distance=None) for p in placements]


@pytest.fixture(scope="module")
def exact(true_panda: Robot) -> list[Placement]:
    generator = np.random.default_rng(3)
    placements = [record(true_panda, base, generator, samples=8) for base in BASES]
    return without_distance(placements)


@pytest.fixture(scope="module")
def noisy(true_panda: Robot) -> list[Placement]:
    generator = np.random.default_rng(4)
    placements = [record(true_panda, b, generator, samples=12, noise=5e-5) for b in BASES]
    return without_distance(placements)


@pytest.mark.slow
def test_a_table_gives_frame_and_sockets_back(panda: Robot, exact: list[Placement]) -> None:
    generator = np.random.default_rng(1)
    frame = random_pose(generator)
    at = sockets_seen(BASES, frame, generator, deviation=1e-6)
    found = fit(panda, exact, at)
    assert not found.scene.arms[0].known  # a default distance is no measurement
    places = found.frames["table"].inverse().apply(found.arms[0].centres)
    assert np.abs(places - np.array([one.coordinates for one in at])).max() < 1e-9


@pytest.mark.slow
def test_an_anchored_base_is_known_within_its_interval(
    panda: Robot, true_panda: Robot, noisy: list[Placement]
) -> None:
    """The base's pose and joint 1's zero: where the ball is in the base frame."""
    generator = np.random.default_rng(2)
    at = sockets_seen(BASES, HOME, generator, noise=5e-5, name="base")
    free, tied = fit(panda, noisy, []).arms[0], fit(panda, noisy, at).arms[0]

    def seen(found: Posterior) -> tuple[str, ...]:
        return unobservable(found, weakly_identifiable_directions(found))

    assert seen(free) == UNOBSERVABLE and seen(tied) == UNOBSERVABLE[1:]
    q = workspace(panda, 40, 1)
    truth = BallModel(true_panda, []).points(np.empty(0), q)
    off = np.abs(tied.predict(q, np.zeros_like(q)) - truth)
    _, jacobian, _ = tied.model.linearise(tied.x, q, np.zeros_like(q))
    size = tied.model.size
    stated = np.sqrt(np.einsum("nij,jk,nik->ni", jacobian, tied.covariance[:size, :size], jacobian))
    assert np.mean(off < 3 * stated) > 0.95
    assert np.median(stated) < 3e-4  # without the anchor some millimetres
    first = [i for i, name in enumerate(tied.model.names) if name == "panda_joint1.yaw"]
    assert deviations(tied)[first] < deviations(free)[first]


def test_coordinates_in_the_wrong_base_frame_are_refused(
    panda: Robot, noisy: list[Placement]
) -> None:
    at = sockets_seen(BASES, HOME, np.random.default_rng(2), name="base")
    turned = [replace(o, coordinates=(-o.coordinates[1], *o.coordinates[::2])) for o in at]
    with pytest.raises(FrameError, match="origin and axes as the URDF's base link does"):
        fit(panda, noisy, turned)
    large = [replace(o, coordinates=tuple(1e3 * v for v in o.coordinates)) for o in at]
    with pytest.raises(FrameError, match="are they millimetres"):
        fit(panda, noisy, large)


def test_two_sockets_in_the_base_leave_it_a_turn(panda: Robot, noisy: list[Placement]) -> None:
    at = sockets_seen(BASES[:1], HOME, np.random.default_rng(2), name="base")
    found = fit(panda, noisy, at).arms[0]
    assert "leave it a turn" in unobservable(found, weakly_identifiable_directions(found))[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", "lite6", "ur3e"])
def test_exact_sockets_in_a_frame_give_every_place_back(name: str) -> None:
    """Where the ball is in a table's frame and in an anchored base, at sockets held out."""
    robot, generator = load_robot(name), np.random.default_rng(1)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    *bases, held = reachable_bases(arm, generator, 5)
    placements = without_distance([record(arm, b, generator, samples=10) for b in bases])
    q = record(arm, held, generator, samples=5).positions
    truth = BallModel(arm, []).points(np.empty(0), q)
    for use, frame in (("table", random_pose(generator)), ("base", HOME)):
        at = sockets_seen(bases, frame, generator, deviation=1e-8, name=use)
        found = fit(robot, placements, at)
        ball = found.arms[0].predict(q, np.tile(0 * q, 3))
        seen = found.frames.get(use, HOME).inverse().apply(ball)
        assert np.abs(seen - frame.inverse().apply(truth)).max() < 1e-9

"""Two arms that visited the same bases."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from calibrated_arm import FACING, HOME, recorded_face_to_face
from worlds import measured_points

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.bases import Visitor, common_places, places_alone, tie
from mukca.solver.calibration import posterior_of, tool_distances
from mukca.solver.design import predicted_posterior
from mukca.solver.identification.data import (
    STANDARD_LOAD,
    Pose,
    fit_pose,
    measure,
    observations_at,
)
from mukca.solver.identification.effects import JOINT_OFFSET
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import (
    BallModel,
    choose_parameters,
    rotation_rpy,
    workspace,
)
from mukca.solver.results import Measurements
from mukca.solver.studies import workspace_errors
from mukca.tools.simulation import perturb

pytestmark = pytest.mark.slow

WITHOUT = ["compliance", "tilt", "transmission", "joint-noise"]


class Pair:
    """A Panda and an arm with six joints, face to face, and what they recorded."""

    def __init__(self, noise):
        generator = np.random.default_rng(6)
        self.robots = {"A": mukca.load_robot("panda"), "B": mukca.load_robot("ur5e")}
        self.truth = [perturb(robot, generator, 2e-3, 5e-3) for robot in self.robots.values()]
        own = recorded_face_to_face(self.truth, generator, noise=noise)
        self.placements = dict(zip(self.robots, own, strict=True))

    def fit(self, names=("front", "left"), **options):
        """Calibrate both on some of the placements."""
        train = {arm: [p for p in own if p.name in names] for arm, own in self.placements.items()}
        return mukca.calibrate(self.robots, train, without=WITHOUT, **options)


@pytest.fixture(scope="module")
def exact():
    return Pair(0.0)


@pytest.fixture(scope="module")
def noisy():
    return Pair(1e-4)


@pytest.fixture(scope="module")
def found(noisy):
    return noisy.fit()


def relative(found):
    """Where the second base stands in the first one's frame."""
    told = found.document.between["A_to_B"]
    return Pose(rotation_rpy(told.rpy).full(), np.array(told.xyz)), told


def test_exact_recordings_tie_the_tools_exactly(exact):
    """At the sockets and away from them, though the base frame is known to millimetres only."""
    found = exact.fit(distance_deviation=1e-7)
    pose, _ = relative(found)
    for a, b in zip(*exact.placements.values(), strict=True):
        near = [a.positions + 0.02, b.positions - 0.02]
        balls = [found[arm].calibrated.ball(q) for arm, q in zip("AB", near, strict=True)]
        true = [
            BallModel(arm, []).points(np.empty(0), q)
            for arm, q in zip(exact.truth, near, strict=True)
        ]
        seen = np.linalg.norm(pose.apply(balls[1]) - balls[0], axis=1)
        expected = np.linalg.norm(FACING.apply(true[1]) - true[0], axis=1)
        assert seen == pytest.approx(expected, abs=1e-9)
    assert np.abs(pose.translation - FACING.translation).max() > 1e-4


def test_noise_makes_errors_as_large_as_stated(noisy, found):
    pose, told = relative(found)
    assert told.shared_sockets == 4
    assert told.tool_deviation is not None and 5e-5 < told.tool_deviation < 1e-3
    errors = []
    for a, b in zip(*noisy.placements.values(), strict=True):
        balls = [found["A"].ball(a.positions), found["B"].ball(b.positions)]
        errors += [pose.apply(balls[1]).mean(axis=0) - balls[0].mean(axis=0)]
    assert np.linalg.norm(errors, axis=1).max() < 3 * told.tool_deviation


def tied(robots, extensions):
    """Arms that are fitted alone, with their bases tied."""
    places, visitors = common_places(robots), []
    for i, one in enumerate(robots):
        alone, sockets = places_alone(places, robots, i)
        model = extend(one.robot, choose_parameters(one.robot), extensions)
        fit = estimate(model, observations_at(alone, one))
        visitors.append(Visitor(one.name, i - 1, sockets, fit))
    return tie(visitors, places)


@pytest.mark.parametrize("extensions", [(), (JOINT_OFFSET.name,)])
def test_an_arm_is_known_alike_whichever_is_the_first(noisy, extensions):
    """Its errors in the workspace, where those of samples are alike, too, and after more."""
    arms = {
        name: Measurements(robot, [measure(p, robot) for p in noisy.placements[name]], name=name)
        for name, robot in noisy.robots.items()
    }
    errors = []
    for names in ("AB", "BA"):
        world = tied([arms[name] for name in names], extensions)
        posterior = world.arms[names.index("B")]
        more = STANDARD_LOAD.by_socket(arms["B"].robot, arms["B"].measurements[0])
        both = posterior, predicted_posterior(posterior, more)
        errors.append([workspace_errors(one, STANDARD_LOAD).median for one in both])
    assert errors[0] == pytest.approx(errors[1], rel=0.05)


def test_tools_meet_as_stated_where_only_an_instrument_saw_both(noisy):
    generator, at = np.random.default_rng(2), np.array([[0.6, 0.1, 0.3], [0.5, -0.2, 0.4]])
    seen = {
        name: [replace(measured_points(arm, pose.inverse(), generator, noise=1e-4), frame="world")]
        for name, arm, pose in zip("AB", noisy.truth, (HOME, FACING), strict=True)
    }
    found = mukca.calibrate(noisy.robots, seen, without=WITHOUT)
    told = found.document.between["A_to_B"]
    assert told.tool_deviation is not None and 3e-5 < told.tool_deviation < 1e-3
    tip = noisy.robots["B"].tip
    for point in at:
        q = [found[name].command(point, tool=found[name].robot.tip, frame="A") for name in "AB"]
        met = found["A"].command(
            np.zeros(3), q[0], tool=found["A"].robot.tip, frame=f"B/{tip}", at=q[1]
        )
        a, b = (
            BallModel(arm, []).points(np.empty(0), row[None])
            for arm, row in zip(noisy.truth, (met, q[1]), strict=True)
        )
        assert np.linalg.norm(FACING.apply(b) - a) < 3 * told.tool_deviation


def test_few_postures_tell_what_they_tell_about_themselves(noisy):
    """An instrument saw each arm in a narrow range of postures, and nothing is known of others."""
    generator = np.random.default_rng(3)
    seen, later = {}, {}
    for name, arm, stand in zip("AB", noisy.truth, (HOME, FACING), strict=True):
        q = workspace(arm, 4000, 0)
        balls = stand.apply(BallModel(arm, []).points(np.empty(0), q))
        middle = q[np.argmin(np.linalg.norm(balls - [0.6, 0.0, 0.35], axis=1))]
        q = middle + generator.uniform(-0.15, 0.15, (80, len(middle)))
        balls = stand.apply(BallModel(arm, []).points(np.empty(0), q))
        points = balls[:40] + generator.normal(0, 1e-4, (40, 3))
        rows = zip(q[:40].tolist(), points.tolist(), strict=True)
        samples = tuple(Sample(tuple(row), 0, point=tuple(point)) for row, point in rows)
        seen[name] = [Placement("points", samples, arm.joint_names, frame="cell")]
        later[name] = q[40:], balls[40:]
    found = mukca.calibrate(noisy.robots, seen, without=WITHOUT)
    pose, told = relative(found)
    predicted = {name: found[name].ball(q) for name, (q, _) in later.items()}
    predicted["B"] = pose.apply(predicted["B"])
    errors = [
        np.linalg.norm(balls[:20] - balls[20:], axis=1)
        - np.linalg.norm(later[name][1][:20] - later[name][1][20:], axis=1)
        for name, balls in predicted.items()
    ]
    for name, error in zip("AB", errors, strict=True):
        near = found[name].document.better.recorded_places.now.value
        assert near < 3 * np.median(np.abs(error))
    apart = np.linalg.norm(predicted["A"] - predicted["B"], axis=1)
    error = apart - np.linalg.norm(later["A"][1] - later["B"][1], axis=1)
    assert told.tool_deviation is not None
    assert 0.3 < told.tool_deviation / np.sqrt(3 * np.mean(error**2)) < 3


def test_arms_that_share_nothing_are_refused(exact):
    train = {"A": exact.placements["A"][0], "B": exact.placements["B"][1]}
    with pytest.raises(mukca.MukcaError, match="nothing ties it to the robot"):
        mukca.calibrate(exact.robots, train, without=WITHOUT)


def test_one_urdf_has_both_arms_where_they_stand(found, tmp_path):
    found.save(tmp_path / "out")
    (file,) = (tmp_path / "out").glob("arms.urdf")
    assert ET.parse(file).getroot().find("link[@name='world']") is not None
    pose, _ = relative(found)
    for name, stands in (("A", HOME), ("B", pose)):
        chain = mukca.load_robot(file, tip=f"{name}_ball_link")
        own = found[name].calibrated
        q = np.linspace(-1, -0.5, len(chain.actuated))[None]
        expected = stands.apply(own.geometric_ball(q))
        assert BallModel(chain, []).points(np.empty(0), q) == pytest.approx(expected, abs=1e-9)


def test_one_urdf_of_bending_arms_has_tools_where_no_other_pose_has_them_better(tmp_path):
    """The full models' pose would have them wrong by millimetres, as both geometries differ."""
    robots = {"A": mukca.load_robot("panda"), "B": mukca.load_robot("ur5e")}
    tracker, generator = (
        Pose(rotation_rpy((0.3, -0.2, 1.0)).full(), np.ones(3)),
        np.random.default_rng(1),
    )
    train, proof = {}, {}
    for k, (name, stand) in enumerate(zip(robots, (HOME, FACING), strict=True)):
        truth, _ = mukca.simulate_recordings(
            robots[name], 1, seed=1 + k, samples=4, compliance=4e-5
        )
        q = workspace(truth.robot, 4000, k)
        balls = stand.apply(truth.ball(q))
        rows = np.flatnonzero(np.all(np.abs(balls - [0.6, 0.0, 0.35]) < 0.25, axis=1))[:80]
        points = tracker.inverse().apply(balls[rows]) + generator.normal(0, 5e-5, (80, 3))
        names = truth.robot.joint_names
        for part, some in ((train, slice(0, 40)), (proof, slice(40, 80))):
            pairs = zip(q[rows[some]].tolist(), points[some].tolist(), strict=True)
            samples = tuple(Sample(tuple(row), 0, point=tuple(point)) for row, point in pairs)
            part[name] = [Placement("points", samples, names, frame="tracker")]
    without = ["tilt", "play", "transmission", "curves", "joint-noise"]
    mukca.calibrate(robots, train, without=without).save(tmp_path / "out")
    arms = mukca.load_cell(tmp_path / "out")
    data = {name: [measure(p, robots[name]) for p in proof[name]] for name in robots}
    loaded = tool_distances(arms, data).loaded.mean
    balls, points, in_frame = [], [], []
    for name in robots:
        chain = mukca.load_robot(tmp_path / "out" / "arms.urdf", tip=f"{name}_ball_link")
        (measured,) = data[name]
        balls.append(BallModel(chain, []).points(np.empty(0), measured.positions))
        points.append(measured.points)
        in_frame.append(fit_pose(balls[-1], measured.points).apply(balls[-1]))

    def error(first, second):
        apart = [np.linalg.norm(a[:, None] - b, axis=2) for a, b in ((first, second), points)]
        return np.abs(apart[0] - apart[1]).mean()

    assert error(*balls) == pytest.approx(loaded)
    assert error(*balls) < 1.1 * error(*in_frame)
    full = arms.pose("B") @ arms.urdf_pose("B").inverse()
    assert error(balls[0], full.apply(balls[1])) > 2 * error(*in_frame)
    told = arms.document.between["A_to_B"]
    assert told.urdf is not None and f"off by {1e3 * told.urdf.tool_error:.2f} mm" in told.text


def test_each_arm_is_a_prior_of_its_own(noisy, found, tmp_path):
    found.save(tmp_path / "out")
    for name, robot in noisy.robots.items():
        (file,) = (tmp_path / "out" / name).glob("calibration.json")
        kept = mukca.load_calibration(file)
        posterior = posterior_of(kept.document, str(file))
        told = [p.standard_deviation for p in kept.document.parameters]
        deviations = np.sqrt(np.diag(posterior.covariance))
        assert deviations[: len(told)] == pytest.approx(told)
        balls = posterior.points
        assert posterior.centres[0] == pytest.approx(
            balls[posterior.data.sockets == 0].mean(axis=0), abs=2e-4
        )
        of_centres = deviations[posterior.model.size :]
        assert of_centres.min() > 0 and of_centres.max() < 0.1
        few = noisy.placements[name][0]
        again = mukca.calibrate(robot, few, without=WITHOUT, prior=file)
        alone = mukca.calibrate(robot, few, without=WITHOUT)
        scales = [one.document.scale.deviation for one in (again, alone)]
        assert scales[0] < scales[1]

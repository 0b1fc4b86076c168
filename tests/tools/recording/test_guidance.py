"""Advice while recording: poses a hand can reach, an honest gauge, and an end."""

import os
import re
import signal
from contextlib import closing
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from record_commands import read
from terminal_session import PATIENCE

import mukca
from mukca.recorder import Placement, Sample
from mukca.recorder.session import BLOCK, Answers, GuidanceRequest
from mukca.solver.design import Reach
from mukca.solver.identification.robot import BallModel, link_poses, load_robot, nominal_balls
from mukca.tools.cli import RobotOptions
from mukca.tools.recording import BackgroundGuidance, PoseSelector, goal_for
from mukca.tools.recording.pose_pool import PosePool

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def samples(session):
    taken = read(session / "front").samples
    return [replace(sample, number=i) for i, sample in enumerate(taken, start=1)]


@pytest.fixture(scope="module")
def coach(panda):
    return PoseSelector(panda, 0.05, goal=1e-6)


@pytest.fixture(scope="module")
def advised(coach, samples):
    """What is said of most of the samples, and then of all."""
    return coach.advise(samples[:-3], 1), coach.advise(samples, 1)


def test_poses_can_be_reached_by_a_hand(panda):
    centre = np.array([0.5, 0.0, 0.1])
    q = Reach(panda).poses(centre, 30)
    assert len(q) == 30
    assert BallModel(panda, []).points(np.zeros(0), q) == pytest.approx(np.tile(centre, (30, 1)))
    lower = np.array([joint.lower for joint in panda.actuated])
    upper = np.array([joint.upper for joint in panda.actuated])
    assert np.all((q - lower) / (upper - lower) > 0.049)
    assert np.all((upper - q) / (upper - lower) > 0.049)
    assert len(Reach(panda).poses(np.array([3.0, 0.0, 0.1]), 10)) == 0


def test_no_link_is_below_the_table():
    """As two of three poses of a UR would be, with a socket this low."""
    robot = load_robot("ur5e")
    q = Reach(robot).poses(np.array([0.7, 0.05, 0.03]), 20)
    heights = link_poses(robot.joints, q)[:, 3:-1, 2, 3]
    assert np.all(heights > 0.03 - 1e-9)


@pytest.mark.parametrize(("name", "z"), [("ur10", 0.25), ("ur3e", 0.2), ("iiwa14", -0.1)])
def test_there_are_poses_with_the_socket_high_or_low(name, z):
    robot = load_robot(name)
    reach = 0.45 * float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    assert len(Reach(robot).poses(np.array([reach, 0.1, z]), 20)) == 20


@pytest.mark.parametrize(("name", "curves"), [("ur10", True), ("ur5e", False)])
def test_error_curves_are_known_of_types_that_have_them(name, curves, monkeypatch):
    """Samples of earlier placements are known as well, in sockets of their own."""
    robot, seen = load_robot(name), []
    route = SimpleNamespace(way=lambda _: np.zeros((24, 6)))
    module = "mukca.solver.design"
    monkeypatch.setattr(f"{module}.CurveAnnealing", lambda *given: seen.append(given) or route)
    monkeypatch.setattr(f"{module}.plan_poses", lambda *_: np.zeros((24, 6)))
    q = Reach(robot).poses(np.array([0.5, 0.0, 0.1]), 5).tolist()
    some = tuple(Sample(tuple(pose), k % 2, number=k) for k, pose in enumerate(q))
    earlier = Placement("front", some, robot.joint_names, 0.05)
    PoseSelector(robot, 0.05, parts=[earlier]).advise(some[:3], 0)
    assert len(seen) == curves
    if curves:
        known, taken, *_ = seen[0]
        assert known.sockets == 4
        assert [(k, len(q)) for q, k in taken] == [(0, 2), (1, 1), (2, 3), (3, 2)]


@pytest.fixture(scope="module")
def early(coach, samples):
    """What is said of the first samples."""
    return coach.advise(samples[:4], 0)


def test_the_prediction_falls_and_each_socket_has_its_turn(coach, samples, advised, early):
    assert not early.fitted and early.target is not None and not early.leave
    assert coach.advise(samples[:BLOCK], 0).leave
    whole = advised[-1]
    assert whole.fitted and whole.predicted < early.predicted
    assert whole.mean_error and whole.mean_error < 1.5e-4
    assert whole.distance == pytest.approx(0.05, abs=1e-4)
    assert whole.last_error and abs(whole.scale or 1) < 0.01
    turned = coach.advise([*samples[12:], *samples[:12]], 0)
    assert turned.last_error != pytest.approx(whole.last_error, rel=1e-3)


def test_poses_are_proposed_anew_after_a_first_sample_that_was_taken_back(panda, samples):
    """Wherever that lay: it may have been taken back because the ball was in no socket."""
    wrong, right = replace(samples[0], position=samples[-1].position), samples[1]
    taught = PoseSelector(panda, 0.05)
    assert taught.advise([wrong], 0).target is not None
    assert taught.advise([], 0).target is None
    q = np.array([wrong.position, right.position, taught.advise([right], 0).target])
    away, there, target = BallModel(panda, []).points(np.zeros(0), q)
    assert np.linalg.norm(target - there) < 1e-6 < np.linalg.norm(away - there)


def test_the_goal_is_enough_but_not_with_too_few(panda, samples):
    easy = PoseSelector(panda, 0.05, goal=1.0)
    few = [s for s in samples if s.number <= 6 or 12 < s.number <= 18]
    assert not easy.advise(few, 1).enough
    done = easy.advise(samples, 1)  # 10 in a socket are the fewest
    assert done.enough and not done.leave


def test_a_goal_within_reach_is_worth_more_samples_and_one_beyond_is_not(panda, samples, advised):
    beyond = advised[-1]
    assert beyond.exhausted and not beyond.enough
    selector = PoseSelector(panda, 0.05, goal=0.97 * beyond.predicted)
    selector.advise(samples[:-3], 1)
    near = selector.advise(samples, 1)
    assert not near.enough and not near.exhausted


def test_a_placement_at_which_no_pose_can_be_reached_is_exhausted(panda, samples):
    """A hand had been there, yet by the nominal model it is out of reach."""

    class OutOfReach(PosePool):
        def candidates(self, *_):
            return np.zeros((0, 7))

    selector = PoseSelector(panda, 0.05)
    selector._pool = OutOfReach(panda, np.inf)
    advice = selector.advise(samples, 1)
    assert advice.target is None and (advice.exhausted or advice.near_only or advice.enough)


@pytest.mark.parametrize(
    ("sockets", "lost", "goal", "ends"),
    [
        ((18, 18), 0, None, 1),
        ((18, 18), 0, 1e-6, 0),
        ((20, 16), 0, None, 1),
        ((20, 15), 0, None, 0),
        ((12, 12), 0, None, 0),
        ((12, 12), 12, None, 1),
    ],
)
def test_a_placement_ends_though_each_sample_still_helps(panda, sockets, lost, goal, ends):
    """Samples that an alarm left in a placement before count as well."""

    class Helped(PoseSelector):
        def _exhausted(self, *_):
            return False

    _, (here, before) = mukca.simulate_recordings(panda, 2, samples=20, noise=5e-4, seed=3)
    first, second = sockets
    taken = [*here.samples[:first], *here.samples[20 : 20 + second]]
    rows = enumerate(taken, start=1)
    samples = [replace(sample, number=number) for number, sample in rows]
    parts = [replace(before, samples=before.samples[6 : 6 + lost])] if lost else []
    for counts in ({"parts": parts}, {"lost": lost}):
        advice = Helped(panda, 0.05, goal, **counts).advise(samples, 1)
        assert (advice.exhausted or advice.near_only or advice.enough) == ends


@pytest.mark.parametrize(("name", "goal"), [("panda", 9e-4), ("ur5e", 9e-4), ("gen3_lite", 3e-3)])
def test_the_goal_is_what_solve_asks(name, goal):
    assert goal_for(load_robot(name)) == pytest.approx(goal)


def test_what_is_predicted_and_asked_is_what_solve_says(panda, samples):
    selector = PoseSelector(panda, 0.05)
    advice = selector.advise(samples, 1)
    placement = mukca.Placement("here", tuple(samples), panda.joint_names, 0.05)
    solved = mukca.calibrate(panda, placement)
    verdict = solved.verdict
    (row,) = (row for row in verdict.limits if row.name == "predicted_distance")
    assert (advice.predicted, advice.goal) == (row.interval.high, row.limit)
    assert advice.enough == (verdict.kind != "not_enough")
    assert advice.near_only == (verdict.kind != "not_enough" and row.status != "pass")
    words, *_ = selector.closing(samples)
    assert f"are known to {1e3 * row.found:.2f} mm. Another placement" in words
    x, side, z = re.fullmatch(
        r".* about (?:(.+) m ahead, )?(.+) m to its left, (.+) m up.*", words
    ).groups()
    text = solved.document.next_placement.text
    place = re.search(r"x (\S+), y (\S+), z (\S+) m in the frame .*[(]left", text).groups()
    assert np.allclose([float(x or 0), float(side), float(z)], np.float64(place), atol=0.02)


def test_what_is_held_out_is_beside_it_already(panda, session, samples):
    for name, alone in ((None, True), ("left", False)):
        parts = [read(session / name)] if name else []
        assert PoseSelector(panda, 0.05, parts=parts).advise(samples, 1).alone == alone


def test_what_was_enough_stays_enough_while_solve_asks_for_no_more(panda, samples, monkeypatch):
    names = ("predicted", "enough", "sized")  # not at first by a size without a margin
    rows = [(1.1e-3, 1, 1), (0.9e-3, 1, 0), (0.9e-3, 1, 1), (1.1e-3, 1, 0), (1.1e-3, 0, 1)]
    each = iter(dict(zip(names, row, strict=True)) for row in rows)

    def solved(*_, **__):
        return SimpleNamespace(**next(each), asked=1e-3, fails="")

    coach = PoseSelector(panda, 0.05)
    monkeypatch.setattr("mukca.tools.recording.guidance.sufficiency_of", solved)
    told = [coach.advise(samples[:20], 1) for _ in rows]
    assert [advice.enough for advice in told] == [False, False, True, True, False]
    assert [advice.near_only for advice in told] == [False, False, False, True, False]


def test_samples_that_solve_refuses_are_an_end(panda, samples):
    """Its reason is told; further samples would not change that."""
    outside = np.add(samples[-1].position, [0, 0, 0, 4, 0, 0, 0])
    refused = [*samples[:-1], replace(samples[-1], position=tuple(outside.tolist()))]
    coach = PoseSelector(panda, 0.05)
    kept = Answers(kept=coach.alarms(refused))
    few, enough = (coach.advise(some, 1, answers=kept) for some in (refused[-12:], refused))
    assert not few.exhausted and enough.exhausted and not enough.enough
    assert "panda_joint4" in enough.fails and "outside its limits" in enough.fails


def test_another_placement_is_weighed(coach, samples):
    words = coach.closing(samples)
    assert (
        "Another placement, seen from the robot about 0." in words[0]
        and "measured to 0.1 mm" in words[1]
    )
    now = float(words[0].split(" known to ")[1].split()[0])
    then, tied = (float(line.split()[-2]) for line in words[:2])
    assert now > then > tied and "sockets 150 mm apart" in words[2]


def test_a_second_placement_is_watched_from_before_its_first_sample(panda, session):
    second = PoseSelector(panda, 0.05, parts=[read(session / "front")])
    here = read(session / "left").samples
    assert not any(second.alarms(here[:taken]) for taken in (0, 1, 3, 6))


def test_a_sample_that_an_alarm_took_back_rings_no_more(panda, samples):
    q = np.add(samples[9].position, [0, 0.02, 0, 0, 0, 0, 0])
    *sound, off = [*samples[:9], replace(samples[9], position=tuple(q.tolist()))]
    selector = PoseSelector(panda, 0.05)
    (told,) = selector.alarms([*sound, off])
    assert (told.cause, told.samples) == ("ball", (off.number,))
    assert not selector.alarms(sound, Answers(doubted=(off,)))


def test_another_arm_is_known_by_how_it_moves(samples):
    other = PoseSelector(load_robot("iiwa14"), 0.05, goal=1e-6)
    assert not other.alarms(samples[:2])
    told = other.alarms(samples[:3])[0].text.replace("fr3", "panda")
    assert "this moves like a panda" in told


def test_no_joint_is_led_farther_than_the_cables_allow(panda, samples, early):
    bound = PoseSelector(panda, 0.05, 1e-6, turn=1.2).advise(samples[:4], 0)
    far, near = (
        np.abs(np.subtract(advice.target, samples[0].position)).max() for advice in (early, bound)
    )
    assert near <= 1.2 < far


def test_poses_come_from_where_the_samples_went_and_not_where_they_cannot_be_taken(panda, samples):
    centre = np.median(nominal_balls(panda, np.array([samples[0].position])), axis=0)
    begin = np.array(samples[0].position)
    near = Reach(panda).poses_between(centre, begin - 0.3, begin + 0.3, 500)[:4]
    assert len(near) == 4
    taken = [Sample(tuple(q), 0, number=i) for i, q in enumerate(near.tolist(), 1)]
    selector = PoseSelector(panda, 0.05)

    def routed(**answers):
        route = selector.advise(taken, 0, answers=Answers(**answers)).route
        return np.array([q for _, q in route])

    free, confined = routed(), routed(confined=True)
    allowed = routed(avoided=(tuple(free[0].tolist()),))
    low, high = near.min(axis=0) - np.deg2rad(10), near.max(axis=0) + np.deg2rad(10)
    assert np.abs(free - begin).max() > 1.5
    assert len(confined) == len(free) and np.all((confined >= low) & (confined <= high))
    assert np.abs(allowed - free[0]).max(axis=1).min() > np.deg2rad(20)
    balls = nominal_balls(panda, confined)
    assert balls == pytest.approx(np.tile(centre, (len(balls), 1)), abs=2e-3)


def test_the_ball_is_lifted_where_no_way_keeps_it_in_its_socket(panda):
    reach = Reach(panda)
    q = reach.poses(np.array([0.5, 0.0, 0.1]), 60)
    seated = reach.seated(q[0], q)
    assert seated[0] and not seated.all()
    near = np.abs(q - q[0]).max(axis=1)
    assert near[seated].mean() < near[~seated].mean()


@pytest.fixture
def background():
    robot = RobotOptions(robot="panda")
    with closing(BackgroundGuidance(robot, distance=0.05, goal=3e-4)) as background:
        yield background


def test_a_process_beside_the_recorder_answers(background, samples, early):
    background.ask(GuidanceRequest(tuple(samples[:4]), 0, None))
    assert not background.idle
    advice = background.answer(wait=PATIENCE)
    assert advice and advice.count == 4 and advice.target and background.idle
    assert advice.predicted == pytest.approx(early.predicted)


def test_a_process_that_dies_is_told(background):
    os.kill(background.pid, signal.SIGKILL)
    assert background.answer(wait=PATIENCE) is None
    assert "process ended" in str(background.trouble) and not background.idle

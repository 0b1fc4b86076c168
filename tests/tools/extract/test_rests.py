"""Every rest is found and no other; what was a sample is proposed as one."""

import numpy as np
import pytest
from cases import by_table

from mukca.drivers.arms import Motion, SimulatedArm
from mukca.recorder import read_placement
from mukca.recorder.stream import JointLimits
from mukca.solver.calibration import UsageError
from mukca.solver.identification.robot import load_robot
from mukca.tools.extract import Log, assign, find_rests, placements_of, propose_samples
from mukca.tools.recording import joints_of


@pytest.fixture(scope="module")
def log(moves):
    return Log(
        np.array([state.stamp for state in moves.states]),
        np.array([state.position for state in moves.states]),
        None,
        np.zeros(len(moves.states), dtype=int),
    )


@pytest.fixture(scope="module")
def found(log):
    return find_rests(log, joints_of(load_robot("panda")), window=0.3, still=5e-4)


def still(position, begin, end):
    rng = np.random.default_rng(int(10 * begin))
    return [(t, position + rng.normal(0, 1e-5)) for t in np.arange(begin, end, 0.02).tolist()]


def rests_of(states, parts=None, **kind):
    stamps, values = (np.array(column) for column in zip(*states, strict=True))
    numbers = np.array(parts) if parts else np.zeros(len(stamps), dtype=int)
    log = Log(stamps, np.stack([values, np.sin(values)], axis=1), None, numbers, **kind)
    joints = (JointLimits("a"), JointLimits("b"))
    return find_rests(log, joints, window=0.3, still=5e-4)


def test_a_rest_torn_by_a_drop_out_is_one(moves):
    (one,) = rests_of(still(0.4, 0, 1.0) + still(0.4, 1.4, 2.4))
    assert one.end - one.begin > 2


def test_no_rest_goes_on_in_the_next_episode_or_before_it_began():
    """An episode begins where the last one ended, and its time at 0."""
    states = [*still(0.4, 0, 1.0), *still(0.4, 0, 1.4)]
    episodes = [0] * 50 + [1] * 70
    for own_clocks in (True, False):
        first, second = rests_of(states, episodes, episodes=own_clocks)
        assert (first.part, second.part) == (0, 1)
        assert 0 < first.end - first.begin < 1 < 1.3 < second.end - second.begin + 0.35
    later = [*still(0.4, 0, 1.0), *still(0.4, 1.1, 2.4)]  # of a connection that was lost
    assert len(rests_of(later, [0] * 50 + [1] * 65)) == 1
    assert len(rests_of(later, [0] * 50 + [1] * 65, episodes=True)) == 2


def test_a_short_stop_and_a_slow_move_are_no_rests():
    slow = [(t, 0.4 + 0.02 * t) for t in np.arange(0, 3, 0.02).tolist()]
    assert rests_of(slow) == []
    assert rests_of(still(0.4, 0, 0.4)) == []


@pytest.mark.parametrize("rate", [10, 15, 20, 25, 30, 33, 50])
@pytest.mark.parametrize("jitter", [0.0, 1e-4])
def test_rests_in_slow_streams(rate, jitter):
    """Whether the window's last step ends just within it or just outside is a matter of luck."""
    rng = np.random.default_rng(0)
    stamps = np.sort(np.arange(0, 27, 1 / rate) + jitter * rng.normal(size=27 * rate))
    phase = np.clip((stamps % 3.2 - 2.4) / 0.8, 0, 1)  # at rest for 2.4 s, then on
    values = 0.5 * (stamps // 3.2 + phase) + 1e-5 * rng.normal(size=len(stamps))
    log = Log(stamps, np.stack([values, values], axis=1), None, np.zeros(len(stamps), dtype=int))
    joints = (JointLimits("a"), JointLimits("b"))
    for window in (0.3, log.least_window)[rate < 15 :]:  # five states are the least to average
        found = find_rests(log, joints, window=window, still=5e-4)
        assert [round(one.pose.position[0] / 0.5, 2) for one in found[:8]] == list(range(8))


def test_no_average_goes_across_two_episodes():
    first, second = still(0.4, 0, 0.5), still(0.4, 0.5, 1.0)
    assert len(rests_of(first + second)) == 1
    assert rests_of(first + second, [0] * len(first) + [1] * len(second)) == []


@by_table("visits")
def test_sockets_are_told_apart_in_whatever_order_they_were_visited(session, visits):
    """Placements are numbered by their first rest, and the socket of that rest is called 0."""
    robot = load_robot("panda")
    truth, places = [], []
    left = {}
    for name in {visit.split()[0] for visit in visits}:
        for sample in read_placement(session / name).samples:
            left.setdefault(f"{name} {sample.socket}", []).append(sample.position)
    share = {visit: len(left[visit]) // visits.count(visit) for visit in visits}
    for visit in visits:
        for _ in range(share[visit]):
            places.append(left[visit].pop())
            truth.append(visit)
    motion = Motion(places, hold=0.8, move=0.6)
    stamps = np.arange(0, motion.duration, 1 / 40)
    states = [SimulatedArm(motion).state(moment) for moment in stamps.tolist()]
    positions = np.array([state.position for state in states])
    log = Log(stamps, positions, None, np.zeros(len(stamps), dtype=int))
    found = find_rests(log, joints_of(robot), window=0.3, still=5e-4)
    assert len(found) == len(truth)
    bases = list(dict.fromkeys(visit.split()[0] for visit in visits))
    first = {base: next(visit for visit in visits if visit.startswith(base)) for base in bases}
    expected = [
        (f"placement_{1 + bases.index(visit.split()[0])}", int(visit != first[visit.split()[0]]))
        for visit in truth
    ]
    proposals = propose_samples(robot, found, joints_of(robot), 0.05)
    assert [(p.placement, p.socket) for p in proposals] == expected
    placements = placements_of(proposals, robot.joint_names, 0.05)
    assert list(placements) == [f"placement_{i + 1}" for i in range(len(bases))]


def test_the_rests_as_the_user_says(found):
    robot = load_robot("panda")
    proposals = propose_samples(robot, found, joints_of(robot), 0.05)
    given = assign(proposals, ["a:0=2-5,7", "a:1=16-20"])
    numbers = {(p.placement, p.socket): [] for p in given}
    for number, proposal in enumerate(given, start=1):
        numbers[proposal.placement, proposal.socket].append(number)
    assert numbers["a", 0] == [2, 3, 4, 5, 7] and numbers["a", 1] == [16, 17, 18, 19, 20]
    assert list(placements_of(given, robot.joint_names, 0.05)) == ["a"]
    for words, said in (
        (["a:0=1-99"], "the rests are 1 to"),
        (["a=1"], "PLACEMENT:SOCKET=RESTS"),
        (["a:0=1", "a:1=1"], "assigned twice"),
        (["a:0=5-2"], "runs backwards; write 2-5"),
    ):
        with pytest.raises(UsageError, match=said):
            assign(proposals, words)

"""Practice with a hand that goes to the proposed pose and socket, and seats the ball."""

import json
from dataclasses import replace

import numpy as np
import pytest
from record_commands import read
from worlds.sessions import Setting

import mukca
from mukca.drivers import clock
from mukca.recorder import Sample, sample_files
from mukca.recorder.session import Advice, Alarm, Answers, Session, View
from mukca.solver.identification.robot import nominal_balls, shipped_robots
from mukca.solver.results import write_files
from mukca.tools.cli import main
from mukca.tools.recording import (
    SessionAlarms,
    ZeroSelector,
    driver_elsewhere,
    joints_of,
    pose_pool,
    recorded_beside,
)
from mukca.tools.simulation import following_hand

pytestmark = pytest.mark.slow


WAITS = "waits"


class Led:
    """A session in which the hand leads."""

    def __init__(self, panda, words):
        self.hand = following_hand(f"mock:{words}", panda, 0.05)
        self.driver = self.hand.connection()
        self.session = Session(joints_of(panda), block=6)

    def rest(self, target=None, alarm=None):
        """Show the hand a view, and return where the arm rests a moment later.

        The target may be none, or awaited.
        """
        count, socket = len(self.session.live), self.session.socket
        advice = None if target == WAITS else Advice(count, socket, 1, 1, target=target)
        self.hand.follow(View(self.session, advice=advice, alarm=alarm))
        clock.sleep(1.5)
        return self.hand.rest

    def capture(self):
        """Capture where the arm rests."""
        number = self.session.next_number
        sample = Sample(self.hand.rest, self.session.socket, number=number)
        self.session = self.session.captured(sample)


def test_it_waits_for_the_capture_and_goes_where_it_is_asked_to(panda, session, virtual_time):
    led = Led(panda, f"{session / 'front'}?follow")
    second, third = read(session / "front").positions[[5, 20]]
    first = led.rest(tuple(second))
    assert led.rest(tuple(second)) == first  # not captured yet
    led.capture()
    assert led.rest(WAITS) == first  # no advice yet
    assert led.rest(tuple(second), Alarm("ball", "NOT SEATED", "look")) == first
    at = led.rest(tuple(second))
    assert np.abs(np.subtract(at, second)).max() < 0.05 < np.abs(np.subtract(at, first)).max()
    led.session = led.session.switched(1)
    assert np.abs(np.subtract(led.rest(tuple(third)), third)).max() < 0.05


def test_it_goes_on_in_the_next_socket_where_zeros_are_to_be_told(
    panda, session, simulated, virtual_time
):
    """No pose in that socket is known yet, and none in the first is wanted any more."""
    led = Led(panda, f"{session / 'front'}?follow")
    selector = ZeroSelector(simulated.calibration, 0.05, target=6)
    for socket in 6 * [0] + 6 * [1]:
        led.session = led.session.switched(socket)
        advice = selector.advise(led.session.live, socket, led.hand.rest)
        led.rest(advice.target)
        assert led.session.refusal(led.hand.rest) is None
        led.capture()
    assert selector.advise(led.session.live, 1).enough


@pytest.mark.parametrize("name", shipped_robots())
def test_what_is_proposed_leads_to_a_new_pose_with_every_arm(
    name, tmp_path, virtual_time, monkeypatch
):
    """The hardest proposal is the one nearest to the samples: the ball is mounted elsewhere."""
    monkeypatch.setattr(pose_pool, "CANDIDATES", 150)
    robot = mukca.load_robot(name)
    _, (here,) = mukca.simulate_recordings(robot, 1, samples=3, translation=6e-3, seed=2)
    write_files(tmp_path, sample_files(here))
    followed = []
    led, pool = Led(robot, f"{tmp_path}?follow"), pose_pool.PosePool(robot, np.inf)
    for number in range(10):
        led.capture()
        if number == 5:
            led.session = led.session.switched(1)
        samples = led.session.live
        poses = pool.candidates(samples, led.session.socket)
        if not len(poses):  # none before a socket's first sample
            poses = pool.candidates(samples, 0)
        target = None
        if len(poses):
            turns = np.abs(poses[:, None] - [sample.position for sample in samples]).max(axis=2)
            target = tuple(poses[turns.min(axis=1).argmin()])
            followed.append(target)
            pool.heed(Answers(followed=tuple(followed)))
        led.rest(target)
        assert led.session.refusal(led.hand.rest) is None


def led_with(robot, session, fault=""):
    """A placement of a session that follows the screen, with a fault."""
    led, poses = Led(robot, f"{session / 'front'}?follow{fault}"), read(session / "front")
    for block, socket in enumerate((0, 1, 0, 1)):
        led.session = led.session.switched(socket)
        for q in poses.positions[poses.sockets == socket][6 * (block // 2) :][:6]:
            led.rest(tuple(q + 0.1))
            led.capture()
    return mukca.Placement("here", led.session.live, robot.joint_names, 0.05)


def test_a_base_that_is_moved_while_the_arm_is_led_makes_no_jump(panda, session, virtual_time):
    led = Led(panda, f"{session / 'front'}?follow&rate=200")
    led.rest()
    led.capture()
    target = tuple(read(session / "front").positions[5])
    led.hand.follow(View(led.session, advice=Advice(1, 0, 1, 1, target=target)))
    positions = []
    until = clock.now() + 0.4
    while clock.now() < until:
        positions.append(led.driver.read(1).position)
    led.hand.move_base()
    positions += [led.driver.read(1).position for _ in range(600)]
    assert np.ptp(positions, axis=0).max() > 0.3
    assert np.abs(np.diff(positions, axis=0)).max() < 0.05


def test_its_samples_are_sound_and_those_of_a_fault_are_not(panda, session, virtual_time):
    alarms = SessionAlarms(panda)
    assert not alarms([led_with(panda, session)])
    moved = alarms([led_with(panda, session, "&fault=base@13:10mm")])[0]
    assert (moved.words, moved.samples[0]) == ("BASE MOVED", 13)


def test_practice_at_each_base_has_one_arm_and_seats_each_ball(tmp_path, virtual_time):
    """One recording of servos leaves more than one arm that fits it."""
    so101 = mukca.load_robot("so101")
    noise = {"noise": 5e-4, "zeros": 0.05}
    _, recorded = mukca.simulate_recordings(so101, 2, samples=12, seed=2, **noise)
    for name, placement in zip(("front", "left"), recorded, strict=True):
        write_files(tmp_path / name, sample_files(placement))
    q = np.random.default_rng(1).uniform(so101.lower, so101.upper, (100, 5))
    front, left = (Led(so101, f"{tmp_path / name}?follow") for name in ("front", "left"))
    arm = front.hand.truth
    assert np.abs(nominal_balls(arm, q) - nominal_balls(left.hand.truth, q)).max() < 1e-6
    first = front.rest()
    front.capture()
    second = front.rest(tuple(np.add(first, 0.1)))
    assert np.linalg.norm(np.diff(nominal_balls(arm, np.array([first, second])), axis=0)) < 3e-4


@pytest.mark.parametrize("seed", [1, 2])
def test_a_joint_that_slips_is_told_after_two_alarms_at_most(panda, seed):
    here = Setting("panda", seed)
    samples = here.samples("none")
    q = np.array([sample.position for sample in samples])
    q[6:, 3] += np.deg2rad(np.repeat([0.6, -0.7, 0.2, -0.3, 0.8], 4)[:18])
    samples = [replace(s, position=tuple(row)) for s, row in zip(samples, q, strict=True)]
    alarms, kept = SessionAlarms(panda), []
    for count in range(8, 25):
        placement = here.placement(tuple(samples[:count]))
        kept += Answers(tuple(kept)).open_alarms(alarms([placement]))
        if kept and kept[-1].words == "JOINT SLIPS":
            break
    assert kept[-1].words == "JOINT SLIPS" and len(kept) <= 3
    mended = here.placement(tuple(here.samples("none")[:8]))
    told = alarms([replace(placement, name="before"), mended])
    assert "JOINT SLIPS" not in [alarm.words for alarm in told]


def test_a_drift_is_kept_though_it_may_be_a_base_that_moved(panda, session, virtual_time):
    """The fit has an unknown for either. A new placement would drift again, and start anew."""
    placement = led_with(panda, session, "&fault=drift@9:5mm")
    (alarm,) = SessionAlarms(panda)([replace(placement, samples=placement.samples[:18])])
    assert alarm.words == "DRIFTS" and [*alarm.answers] == ["keep"]
    assert alarm.text == "the base drifts, by 3.2 mm so far; as likely the base moved by 2.5 mm"
    kept = Answers((alarm,))
    later = [replace(alarm, words=words, cause="base") for words in ("DRIFTS", "BASE MOVED")]
    ball = replace(alarm, words="NOT SEATED", cause="ball", samples=(30,))
    assert kept.open_alarms([*later, ball]) == (ball,)  # it goes on, and was answered


def test_a_base_that_fell_back_leaves_out_the_samples_of_that_time_alone(
    panda, session, virtual_time
):
    samples = led_with(panda, session, "&fault=base@10+3:3mm").samples
    alarms = SessionAlarms(panda)
    for count in (14, 24):
        here = mukca.Placement("here", samples[:count], panda.joint_names, 0.05)
        (alarm,) = alarms([here])
        assert (alarm.words, alarm.samples) == ("BASE TIPPED", (10, 11, 12))
        assert alarm.reason.endswith("in samples 10 to 12: {delete} take back, {keep} keep")
    others = tuple(sample for sample in samples if sample.number not in alarm.samples)
    assert not alarms([replace(here, samples=others)], doubted=samples[9:12])


def test_balls_far_off_twice_in_a_row_are_joints(panda, session, virtual_time):
    words = "&fault=ball@13:150mm&fault=ball@14:120mm"
    *sound, first, second = led_with(panda, session, words).samples[:14]
    alarms = SessionAlarms(panda)
    (alarm,) = alarms([mukca.Placement("here", (*sound, first), panda.joint_names, 0.05)])
    assert (alarm.words, alarm.samples) == ("NOT SEATED", (13,))
    placement = mukca.Placement("here", (*sound, second), panda.joint_names, 0.05)
    (alarm,) = alarms([placement], doubted=[first])
    assert (alarm.words, alarm.samples) == ("JOINTS?", (13, 14))
    assert "0.1 m off since sample 13" in alarm.reason


def test_after_joints_read_otherwise_earlier_placements_tell_nothing(panda, tmp_path):
    for number, changed in enumerate((False, True, False)):
        sample = Sample((0.1 * number,) * 7, 0, time=float(number + 1))
        files = sample_files(mukca.Placement("here", (sample,), panda.joint_names, 0.05))
        write_files(tmp_path / str(number), files)
        metadata = {"model_sha256": panda.sha256, "readings_changed": changed}
        (tmp_path / str(number) / "placement.json").write_text(json.dumps(metadata))

    def beside(name):
        return [
            placement.files[0].parent.name for placement in recorded_beside(tmp_path / name, panda)
        ]

    assert beside("3") == ["1", "2"] and beside("1") == []


@pytest.mark.parametrize(
    ("change", "count"),
    [
        ({}, 1),
        ({"driver": "franka:10.0.0.2"}, 0),
        ({"driver": "mock:left.csv"}, 0),
        ({"serial_number": "2"}, 0),
        ({"serial_number": None}, 1),
        ({"robot_name": "left"}, 0),
        ({"sockets": 1}, 0),
        ({"sockets": 3}, 1),
    ],
)
def test_placements_of_another_arm_beside_it_are_none_of_its(panda, tmp_path, change, count):
    origin = {"driver": "franka:10.0.0.1", "serial_number": "1"}
    origin |= {"robot_name": "right", "sockets": 2}
    for name, facts in (("before", {**origin, **change}), ("now", origin)):
        facts = {key: value for key, value in facts.items() if value is not None}
        session = {key: facts.pop(key) for key in ("driver", "serial_number") if key in facts}
        placement = mukca.Placement("here", (Sample((0.1,) * 7, 0),), panda.joint_names, 0.05)
        write_files(tmp_path / name, sample_files(placement))
        metadata = {"model_sha256": panda.sha256, "sessions": [{}, session], **facts}
        (tmp_path / name / "placement.json").write_text(json.dumps(metadata))
    assert len(recorded_beside(tmp_path / "now", panda)) == count


def test_no_new_placement_is_offered_to_take_all_samples(panda, session, virtual_time):
    placement = led_with(panda, session, "&fault=ball@1:500mm")
    (alarm,) = SessionAlarms(panda)([replace(placement, samples=placement.samples[:12])])
    assert alarm.words == "JOINTS?" and alarm.samples == (1,)
    assert alarm.reason.endswith(": {delete} take back, {keep} keep")
    for size, words, answer in (
        (30, "BASE MOVED", "keep"),
        (320, "JOINTS?", "finish"),
    ):
        samples = led_with(panda, session, f"&fault=base@13:{size}mm").samples
        remaining = mukca.Placement("here", samples[12:], panda.joint_names, 0.05)
        alarm, *_ = SessionAlarms(panda)([remaining], doubted=samples[:12])
        assert (alarm.words, alarm.samples[0]) == (words, 13)
        assert next(iter(alarm.answers)) == answer


@pytest.mark.parametrize(("size", "words"), [(3, "BALL MOVED"), (25, "TOOL CHANGED?")])
def test_a_ball_taken_off_and_on_begins_a_placement_that_is_sound(
    panda, session, virtual_time, size, words
):
    """The next placement has the ball elsewhere throughout: no key would change that."""
    samples = led_with(panda, session, f"&fault=bent@9:{size}mm").samples
    alarms = SessionAlarms(panda)
    placements = [
        mukca.Placement(name, some, panda.joint_names, 0.05)
        for name, some in (("here", samples), ("front", samples[:8]), ("front-2", samples[8:]))
    ]
    alarm, *_ = alarms(placements[:1])
    assert (alarm.words, alarm.samples[0], next(iter(alarm.answers))) == (words, 9, "new")
    assert (alarm.cause == "joints") == (size > 10)  # with another tool earlier ones tell nothing
    assert not alarms(placements[1:])


def test_without_a_guide_it_leads_through_the_recording(session, tmp_path, virtual_time, capsys):
    keys, out = tmp_path / "keys.txt", tmp_path / "out"
    keys.write_text("a*3 s a*2 s a q")
    driver = f"mock:{session / 'front'}?follow&rate=100&speed=5"
    words = ["record", "--robot", "panda", "--driver", driver, "--distance", "0.05"]
    assert main([*words, "--out", str(out), "--keys", str(keys)]) == 0
    recorded, taken = read(session / "front"), read(out)
    assert taken.sockets.tolist() == [0, 0, 0, 1, 1, 0]
    rows = [recorded.positions[recorded.sockets == k] for k in (0, 1)]
    led = np.concatenate([rows[0][:3], rows[1][:2], rows[0][3:4]])
    assert np.abs(taken.positions - led).max() < 0.02


def test_a_simulated_arm_finds_its_next_base_in_the_next_folder(tmp_path):
    for name in ("front", "front-led", "left", "right"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "samples.csv").touch()
    practised = json.dumps({"sessions": [{"driver": f"mock:{tmp_path}/front"}]})
    (tmp_path / "front-led" / "placement.json").write_text(practised)
    at = [f"mock:{tmp_path / name}?follow&rate=100" for name in ("front", "left", "right")]
    assert [driver_elsewhere(driver) for driver in at] == [at[1], at[2], None]
    assert driver_elsewhere("franka:10.0.0.1") == "franka:10.0.0.1"

"""Nominal models warn of a hand on the arm, and of a ball that was elsewhere."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import seats
from cases import by_table
from kept import compare
from record_commands import fast, read

import mukca
from mukca.recorder import METADATA, SAMPLES, Placement, Sample, sample_files
from mukca.recorder.session import Advice, Session, View
from mukca.recorder.terminal import render
from mukca.solver.identification.robot import gravity_moments, load_robot
from mukca.tools.recording import SessionAlarms, joints_of
from mukca.tools.simulation import Session as FaultySession
from mukca.tools.simulation import SessionFault, with_faults
from mukca.tools.simulation.session_faults import session_faults


def hand_of(folder, *samples):
    """A recording that a simulated arm replays."""
    folder.mkdir()
    for name, content in sample_files(Placement("hand", samples)).items():
        (folder / name).write_bytes(content)
    assert (folder / SAMPLES).exists() and not (folder / METADATA).exists()
    return folder


@by_table("gravity", "words", "fault", "told")
def test_a_hand_is_noticed_by_efforts_beyond_gravity(
    panda, session, tmp_path, scripted, gravity, words, fault, told
):
    first = read(session / "front").samples[0]
    torques = gravity_moments(panda, read(session / "front").positions[:1], gravity)[0, :7]
    sample = Sample(first.position, 0, tuple(torques.tolist()), number=1)
    hand, out = hand_of(tmp_path / "hand", sample), tmp_path / "front"
    driver = fast(hand, out)[fast(hand, out).index("--driver") + 1] + fault
    done = scripted(out, "a q", "--driver", driver, *words)
    assert done.status == 0, done.errors
    assert ("while the arm was pushed (panda_joint" in done.output) == told
    assert len(read(out).efforts[0]) == 7


@pytest.mark.slow
def test_samples_of_the_other_socket_are_told_and_no_others(session, tmp_path, scripted):
    done = scripted(tmp_path / "front", "a*12 1 a*10 0 a*2 q", hand=session / "front")
    assert "! WRONG SOCKET: samples 23 to 24 lie in socket 1" in done.output
    done = scripted(tmp_path / "sound", "a*12 1 a*12 q", hand=session / "front")
    assert "!" not in done.output and done.status == 0
    unmeasured = replace(read(tmp_path / "sound"), distance=None)
    assert not SessionAlarms(load_robot("panda"))([unmeasured])


@pytest.mark.slow
@by_table("fault", "told")
def test_faults_for_practice_are_told(session, tmp_path, scripted, fault, told):
    """Screens are kept: ``MUKCA_KEEP_PAGES=1`` writes them anew after a change that is meant."""
    out = tmp_path / "front"
    driver = f"mock:{session / 'front'}?rate=250&speed=8&hold=0.65&move=0.6&fault={fault}"
    done = scripted(out, "a*12 s a*12 q", "--driver", driver)
    assert re.search(f"! {told}", done.output), done.output
    assert done.status == 0  # it is recorded whole; check says whether it is sound
    screens = Path(__file__).parent / "screens"
    compare(screens / f"{re.split('[@:]', fault)[0]}.txt", screen_after(out))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["panda", "koch"])
def test_a_wrong_sign_and_a_wrong_unit_are_told_before_any_fault(name):
    """The zeros of the second may be off by degrees, and its gears have play."""
    robot = load_robot(name)
    _, (sound,) = mukca.simulate_recordings(robot, 1, samples=6, seed=2)
    alarms, joint = SessionAlarms(robot), len(robot.actuated) // 2
    q = sound.positions.copy()
    q[:, joint] *= -1
    turned = Placement.of_arrays("turned", q, sound.sockets, robot.joint_names)
    assert not alarms([sound])
    for told in (turned, replace(turned, samples=turned.samples[:7])):
        (alarm,) = alarms([told])
        assert alarm.words == "WRONG SIGNS?" and robot.joint_names[joint] in alarm.text
        assert next(iter(alarm.answers)) == "finish"
    metres = replace(sound, distance=10 * sound.distance)
    alarm, *_ = alarms([replace(metres, samples=sound.samples[:7])])
    assert alarm.words == "DISTANCE?" and next(iter(alarm.answers)) == "measure"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["panda", "ur5e", "gen3_lite"])
@pytest.mark.parametrize("degrees", [50, 86])
def test_a_joint_that_reads_far_otherwise_is_named_with_the_first_such_sample(name, degrees):
    """So it is while it lasts, and where all samples of a placement read so."""
    robot = load_robot(name)
    _, (sound,) = mukca.simulate_recordings(robot, 1, samples=6, seed=2)
    alarms, joint = SessionAlarms(robot), len(robot.actuated) // 2
    q = sound.positions.copy()
    q[:, joint] += np.deg2rad(degrees)
    since = sound.with_positions(np.concatenate([sound.positions[:9], q[9:]]))
    rows = [replace(sample, number=i) for i, sample in enumerate(since.samples, start=1)]
    assert not alarms([replace(since, samples=tuple(rows[:9]))])
    for count in (11, 12)[: 1 if alarms.coarse else 2]:
        (alarm,) = alarms([replace(since, samples=tuple(rows[:count]))])
        assert alarm.words == "JOINTS?"
        assert alarm.text == f"{robot.joint_names[joint]} reads far otherwise since sample 10"
        assert [*alarm.answers] == ["finish", "new", "keep"]
    if not alarms.coarse:
        (alarm,) = alarms([sound.with_positions(q)])
        assert (alarm.words, next(iter(alarm.answers))) == ("WRONG ZERO?", "finish")
        assert robot.joint_names[joint] in alarm.text


@pytest.mark.slow
def test_a_base_that_moved_twice_before_is_loose(panda):
    """Whether it moved as well or not, a session that is cut again and again has an end."""
    truth, (*before, here) = mukca.simulate_recordings(panda, 3, samples=12, seed=2)
    session = (panda, here.positions, here.sockets, seats(truth, here), np.random.default_rng(1))
    fault = SessionFault("base", 7, size=5e-3)
    here = here.with_positions(with_faults(FaultySession(*session), [fault]))
    short = [replace(p, samples=(*p.samples[:4], *p.samples[-4:])) for p in before]
    alarms = SessionAlarms(panda)
    for placements, *told in ((before, "BASE MOVED", "new"), (short, "LOOSE BASE", "finish")):
        (alarm,) = alarms([*placements, here])
        assert [alarm.words, next(iter(alarm.answers))] == told
    assert "new" in alarm.answers


@pytest.mark.slow
def test_a_first_joint_that_slips_is_no_base_that_moved(panda):
    _, (here,) = mukca.simulate_recordings(panda, 1, samples=12, seed=2)
    q = here.positions.copy()
    q[:, 0] += np.deg2rad(np.repeat([0, 0, 0.6, -0.7, 0.2, -0.3], 4))
    (alarm,) = SessionAlarms(panda)([here.with_positions(q)])
    assert alarm.words == "JOINT SLIPS" and "panda_joint1" in alarm.text


def test_a_fault_that_is_named_twice_is_one():
    address, faults = session_faults("hand.csv?fault=base@6&noise=0&fault=base@6")
    assert address == "hand.csv?noise=0" and len(faults) == 1


@pytest.mark.slow
def test_several_balls_that_were_not_seated_are_told_one_by_one(session, tmp_path, scripted):
    """They are no ball that is loose, which no key cures."""
    faults = "&".join(f"fault=ball@{number}:5mm" for number in (9, 13))
    driver = f"mock:{session / 'front'}?rate=250&speed=8&hold=0.65&move=0.6&{faults}"
    done = scripted(tmp_path / "front", "a*12 s a*3 q", "--driver", driver)
    told = re.findall(r"! ([A-Z ?]+): sample (\d+)", done.output)
    assert sorted(told) == [("NOT SEATED", "13"), ("NOT SEATED", "9")], done.output


def screen_after(out):
    """Return the screen of 80 x 24 after the samples of a recording, as text."""
    robot, here = load_robot("panda"), replace(read(out), distance=0.05)
    alarms = SessionAlarms(robot)([here])
    samples = tuple(replace(s, time=None, spread=()) for s in here.samples)
    made = Session(joints_of(robot), socket=1, samples=samples)
    made = made.with_message(f"{alarms[0].words}: {alarms[0].text}", alarm=True)
    advice = Advice(len(samples), 1, 1e-3, 9e-4, alarms=alarms)
    facts = {"advice": advice, "alarm": alarms[0], "rate": 250, "age": 0.004}
    view = View(made, samples[-1].position, "panda", **facts)
    return [line.plain.rstrip() for line in render(view, 80, 24, ascii_only=True)]

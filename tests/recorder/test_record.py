"""The recorder's loop with a simulated arm: keys of a script or a hand, faults, hands free."""

import json
import math
import os
import re
import shutil
import signal
import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from altered import write_rows
from cases import by_table
from terminal_session import PATIENCE

from mukca import MukcaError
from mukca.drivers import Reconnecting, clock, open_driver
from mukca.recorder import Metadata
from mukca.recorder.session import Advice, Alarm, Recording, Session, View
from mukca.recorder.stream import JointLimits, Stream, StreamMonitor
from mukca.recorder.terminal import Recorder, Script, keys_with, render

PLACES = [(0.1, 0.2), (0.6, -0.4), (0.2, 0.5), (-0.5, 0.1), (0.9, 0.9)]
JOINTS = (JointLimits("a", -1, 1), JointLimits("b", -1, 1))


@dataclass
class Seen:
    """A display that remembers."""

    views: list[View] = field(default_factory=list)
    bells: int = 0
    sleep: float = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def show(self, view):
        self.views.append(view)
        clock.sleep(self.sleep)

    def bell(self):
        self.bells += 1

    @property
    def alarms(self):
        return [message.text for message in self.views[-1].session.messages if message.alarm]


@dataclass
class Timed(Seen):
    """A display that remembers when its bell rang, too."""

    rang: list[float] = field(default_factory=list)

    def bell(self):
        self.rang.append(clock.now())

    @property
    def rhythm(self):
        """Times of the bell in quarters of a second, from the first one on."""
        return tuple(round(4 * (time - self.rang[0])) for time in self.rang)


NAMES = tuple(joint.name for joint in JOINTS)


@pytest.fixture
def arm(tmp_path):
    """Return the address of a simulated arm that rests at some places, with some faults."""

    def arm(*faults, places=PLACES, speed=8.0, hold=1.0, buffer=math.inf):
        file = write_rows(tmp_path / "hand.csv", places)
        options = [f"rate=200&hold={hold}&move=0.6&speed={speed}&buffer={buffer}"]
        return f"{file}?{'&'.join([*options, *(f'fault={fault}' for fault in faults)])}"

    return arm


@pytest.fixture
def record_in_real_time(tmp_path):
    """Run a session by a script or by a keyboard: its outcome, and what was shown."""

    def run(address, script=None, seen=None, target=3, **more):
        seen = seen or Seen()
        metadata = Metadata("arm", NAMES, ("rad", "rad"), 0.05)
        with Recording(tmp_path / "front", metadata) as recording, ExitStack() as stack:
            if script:
                reader, writer = os.pipe()
                os.write(writer, script.encode())
                os.close(writer)
                stack.callback(os.close, reader)
                more["script"] = Script(reader)
            arm = lambda: open_driver("mock", address, NAMES)  # noqa: E731
            silence = more.pop("silence", 0.1)
            stream = Stream(Reconnecting(arm, first_wait=0.05, silence=silence))
            stack.callback(stream.close)
            settings = {name: more.pop(name) for name in ("block", "keys") if name in more}
            session, monitor = (
                Session(JOINTS, target=target, **settings),
                StreamMonitor(JOINTS, live=not script),
            )
            return Recorder(session, stream, monitor, recording, seen, **more).run(), seen

    return run


@pytest.fixture
def record(record_in_real_time, virtual_time):
    return record_in_real_time


@pytest.fixture
def by_hand(record, virtual_time):
    """Run a session without a script, in which keys are typed at moments of the arm's time."""

    def run(address, *typed, **more):
        return record(address, keyboard=Typist(virtual_time, typed), target=2, **more)

    return run


def positions(outcome):
    return np.array([sample.position for sample in outcome.session.live])


def test_a_script_does_the_same_however_busy_the_computer_is(arm, record, tmp_path):
    outcome, _ = record(arm(), "a*2 s a q")
    (tmp_path / "front/samples.csv").unlink()
    slow, _ = record(arm(), "a*2 s a q", Seen(sleep=0.3))
    assert [s.position for s in slow.session.live] == [s.position for s in outcome.session.live]


@by_table("fault", "told")
def test_every_misbehaviour_is_refused_with_its_reason(arm, record, virtual_time, fault, told):
    """A key is pressed again and again, from before the fault until after it."""
    source = arm(fault, places=[(0.1, 0.2)], speed=1.0)
    again = [(0.03 * k, "ua") for k in range(1, 100)]
    outcome, seen = record(source, "wait=2.6 q", keyboard=Typist(virtual_time, again))
    reasons = [text for text in seen.alarms if text.startswith("refused")]
    assert any(told in reason for reason in reasons), reasons
    for sample in outcome.session.samples:
        begun = sample.stamp - (sample.states - 1) / 200
        noticed = 0.25 if "freeze" in fault else 0.0
        assert sample.stamp < 0.8 + noticed or begun >= 1.8 - 1e-9
        assert sample.position == pytest.approx((0.1, 0.2), abs=1e-4)
    assert seen.bells


def test_a_lost_stream_is_told_within_a_second_and_its_return_too(arm, record):
    _, seen = record(arm("drop@1.2+1.0", speed=1.0), "a wait=1 a q")
    times = [view for view in seen.views if view.session.messages]
    lost = next(v for v in times if "the stream is silent" in v.session.messages[-1].text)
    assert lost.age < 1.0
    assert any("the stream is back after" in m.text for m in seen.views[-1].session.messages)


def test_no_view_counts_what_is_not_on_the_disk(arm, record, tmp_path):
    file = tmp_path / "front/samples.csv"

    class Checking(Seen):
        def show(self, view):
            super().show(view)
            assert file.read_bytes().count(b"\ncapture") >= len(view.session.samples)

    outcome, seen = record(arm(), "a*4 q", Checking())
    assert len(outcome.session.samples) == 4 and len(seen.views) >= 2


@pytest.mark.slow
def test_more_states_than_can_be_looked_at_stop_neither_keys_nor_screen(arm, record_in_real_time):
    """In real time: a thread reads as fast as it can."""
    source = arm(speed=10_000.0)  # two million states a second
    outcome, seen = record_in_real_time(source, "a*5 !s !0 q")
    assert len(outcome.session.live) == 5
    ends = []

    def end():
        ends.append(time.monotonic())
        signal.raise_signal(signal.SIGTERM)

    class Ending(Seen):
        def show(self, view):
            super().show(view)
            if len(self.views) == 5:
                end()

    source = arm(places=[PLACES[0]], speed=10_000.0)
    patience = threading.Timer(PATIENCE, end)
    patience.start()
    outcome, seen = record_in_real_time(source, "wait=1000000000", Ending())
    patience.cancel()
    assert outcome.signal == signal.SIGTERM and time.monotonic() - ends[0] < 120
    assert len(seen.views) > 3


def test_a_slow_screen_loses_no_state(arm, record):
    source = arm(speed=1.0, buffer=2.0)
    _, seen = record(source, "wait=3 q", Seen(sleep=0.4))
    assert seen.views[-1].missed == 0 and len(seen.views) < 12


def test_a_computer_that_is_slower_than_the_stream_still_sees_where_the_arm_is(arm, by_hand):
    """Of 1600 states a second it looks at 500 for each drawing, which takes 0.35 s."""
    pressed = [(12.0 + 0.3 * i, " ") for i in range(6)]
    outcome, seen = by_hand(arm(hold=600), *pressed, (14.0, "q"), seen=Seen(sleep=0.35))
    assert len(outcome.session.live) == 1
    assert max(view.age for view in seen.views[1:]) < 1.1


class Typist:
    """A keyboard on which keys are typed at given moments."""

    def __init__(self, time, typed):
        self.watched = {}
        self._reader, self._writer = os.pipe()
        self._typed = [(time.now() + moment, keys) for moment, keys in typed]
        time.peers.append(self)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def fileno(self):
        return self._reader

    def read(self):
        names = {" ": "space", "\r": "Enter"}
        return [names.get(key, key) for key in os.read(self._reader, 100).decode()]

    def dispatch(self, readable):
        pass

    def due(self):
        return self._typed[0][0] if self._typed else math.inf

    def send_due(self):
        os.write(self._writer, self._typed.pop(0)[1].encode())


def test_a_key_that_waited_is_dropped_and_never_carried_out_at_another_pose(arm, by_hand):
    """The screen holds the recorder up for three seconds, in which the arm moves on."""

    class Held(Seen):
        def show(self, view):
            self.sleep = 3.0 if len(self.views) == 15 else 0.0
            super().show(view)

    typed = (1.2, "a"), (7.2, "a"), (9.0, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, seen=Held())
    assert [round(sample.stamp) for sample in outcome.session.live] == [7]
    assert any(
        alarm.startswith("dropped a: the recorder was held up for 3") for alarm in seen.alarms
    ), seen.alarms


def moved_numbers(outcome):
    """The numbers here of the samples that stand in the next placement."""
    numbers = {sample.position: sample.number for sample in outcome.session.samples}
    return [numbers[sample.position] for sample in outcome.successor.content.live]


def words_of(seen):
    """The banner's words, each time that they changed."""
    words = [view.prompt.words for view in seen.views]
    return [b for a, b in zip(["", *words], words, strict=False) if a != b]


@pytest.mark.slow
def test_hands_free_waits_for_a_key_between_sockets_and_counts_samples(arm, by_hand):
    outcome, seen = by_hand(
        arm(speed=1.0), (0.5, "a"), (4.6, "u"), (8.0, "s"), (20.0, "q"), hands_free=True
    )
    taken = [(s.socket, s.position[0]) for s in outcome.session.live]
    assert [socket for socket, _ in taken] == [0, 0, 1]
    assert 2 in outcome.session.withdrawn
    assert taken[0][1] == pytest.approx(0.1, abs=1e-4)
    words = words_of(seen)
    assert words[1] == "SOCKET 0 NOW" and "SOCKET 1 NOW" in words and "PRESS" not in words


def test_hands_free_does_not_take_again_what_was_taken_back(arm, by_hand):
    outcome, _ = by_hand(arm(speed=1.0), (0.5, "a"), (2.4, "u"), (4.4, "q"), hands_free=True)
    assert outcome.session.withdrawn == (2,)
    assert outcome.session.samples[1].stamp > 1.6 + 0.5  # it rests from 1.6 on; two windows
    assert positions(outcome)[:, 0] == pytest.approx([0.1, 0.2], abs=1e-4)


@pytest.mark.slow
def test_hands_free_takes_no_implausible_pose_and_has_no_patience_to_lose(arm, by_hand):
    def doubt(samples):
        return "is elsewhere." if samples[-1].position[0] > 0.5 else None

    outcome, seen = by_hand(
        arm(speed=1.0, places=PLACES[:3]), (0.5, "a"), (35.0, "q"), hands_free=True, plausible=doubt
    )
    assert positions(outcome)[:, 0] == pytest.approx([0.1, 0.2], abs=1e-4)
    assert seen.alarms == ["this pose is elsewhere. space captures it all the same"]


def test_press_is_never_said_where_it_would_be_refused(arm, by_hand):
    """A key is pressed whenever the banner says so, and at no other time."""
    typed = (0.5, "a"), (3.8, "a"), (6.0, "s"), (9.0, "q")
    outcome, seen = by_hand(arm(speed=1.0, hold=2.5), *typed)
    assert outcome.refused == 0 and outcome.session.counts == (2, 0)
    for view in seen.views:
        if view.prompt.words == "PRESS":
            assert view.position and view.session.refusal(view.position) is None
            assert view.session.counts[view.session.socket] < view.session.target
    assert {"GOT 1", "NEXT POSE", "MOVE", "SOCKET 1 NOW", "PRESS"} <= set(words_of(seen))


def test_a_new_placement_is_asked_for_first(arm, by_hand):
    typed = (0.5, "a"), (1.2, "n"), (1.3, "n"), (2.5, "a"), (3.0, "n"), (3.2, "y"), (6.0, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed)
    assert moved_numbers(outcome) == [] and len(outcome.session.live) == 2
    assert "MOVED?" in words_of(seen)


def test_nothing_is_captured_while_a_number_is_typed(arm, by_hand):
    typed = (0.5, "a"), (1.6, "x"), (9.0, "qq")
    outcome, seen = by_hand(arm(speed=1.0), *typed, hands_free=True)
    assert len(outcome.session.live) == 1 and "WHICH?" in words_of(seen)


@pytest.mark.parametrize(
    ("sound", "pressed", "bells"),
    [(True, (0.5,), 1), (True, (0.1,), 2), (True, (0.5, 2.0), 1 + 3), (False, (0.1, 0.5), 0)],
)
def test_a_captured_sample_is_one_tone_a_refused_two_and_the_end_three(
    arm, by_hand, sound, pressed, bells
):
    typed = [(moment, "a") for moment in pressed]
    assert by_hand(arm(speed=1.0), *typed, (3.5, "q"), sound=sound)[1].bells == bells


def test_other_keys_can_capture_and_numbers_are_typed(arm, by_hand):
    keys = keys_with(["capture=+"])
    typed = (0.5, "+"), (2.0, "+"), (3.0, "x1"), (3.1, "q"), (3.2, "l2 1"), (3.3, "\r"), (3.5, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, keys=keys)
    assert outcome.session.counts == (1, 1)
    assert any(view.prompt.text.startswith("PRESS: + captures sample 1,") for view in seen.views)
    assert any(
        view.prompt.words == "WHICH?" and "delete sample: 1_" in view.prompt.reason
        for view in seen.views
    )


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (["capture=Enter,PageDown"], {"Enter": "capture", "PageDown": "capture"}),
        (["capture=Enter,keep=PageDown,PageUp"], {"Enter": "capture", "PageUp": "keep"}),
        (["yes=PageUp", "new=+,capture=="], {"PageUp": "yes", "+": "new", "=": "capture"}),
    ],
)
def test_a_pedal_can_answer_and_one_setting_can_be_a_list(settings, expected):
    keys = keys_with(settings)
    assert {key: keys[key] for key in expected} == expected


def test_no_action_is_left_without_a_key():
    with pytest.raises(
        MukcaError, match=re.escape("no key is left for next; give it one: --key ne")
    ):
        keys_with(["capture=s"])
    assert keys_with(["capture=s", "next=n,new=w"])["s"] == "capture"


@pytest.mark.parametrize("settings", [["next=p,keep=P"], ["next=p", "keep=p"]])
def test_a_key_has_one_action(settings):
    assert keys_with(["keep=p", "keep=p"])["p"] == "keep"
    with pytest.raises(MukcaError, match="is given to next already; one action a key"):
        keys_with(settings)


@pytest.mark.parametrize("setting", ["capture=Enter,shoot=+", "keep=Enter,", "keep", "=Enter"])
def test_a_list_with_an_unknown_part_is_refused(setting):
    with pytest.raises(MukcaError, match=re.escape(f"--key {setting}: ")):
        keys_with([setting])


def test_a_pedal_keeps_what_an_alarm_says(arm, by_hand):
    adviser = Guidance({}, {}, {"alarms": (BASE,)})
    typed = (0.5, "a"), (2.2, "a"), (3.5, "+"), (5.6, "q")
    by_hand(arm(speed=1.0), *typed, guidance=adviser, keys=keys_with(["capture=a,keep=+"]))
    assert adviser.asked[-1].answers.kept == (BASE,)


class Guidance:
    """Says what it is told to, as soon as it is asked."""

    def __init__(self, *said):
        self.trouble = None
        self.idle = True
        self.asked = []
        self._said = list(said)

    def ask(self, question):
        self.asked.append(question)
        self.idle = False

    def answer(self):
        if self.idle:
            return None
        self.idle = True
        question = self.asked[-1]
        count = question.samples[-1].number if question.samples else 0
        said = self._said[min(count, len(self._said) - 1)]
        return Advice(len(question.samples), question.socket, 5e-4, 3e-4, **said)


def test_advice_ends_a_socket_and_the_placement(arm, by_hand):
    adviser = Guidance({}, {"leave": True}, {"enough": True, "closing": ("go left",)})
    typed = (0.5, "a"), (1.9, "s"), (2.2, "a"), (4.5, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser, sound=True)
    assert outcome.session.counts == (1, 1)
    assert [(len(q.samples), q.socket) for q in adviser.asked] == [(0, 0), (1, 0), (1, 1), (2, 1)]
    words = words_of(seen)
    assert words.index("SOCKET 1 NOW") < words.index("ENOUGH")
    assert outcome.advice and outcome.advice.closing == ("go left",)
    assert seen.bells == 1 + 3 + 1 + 6  # captured, done here, captured, enough


def test_a_capture_a_refusal_and_each_end_sound_unlike_the_others(arm, by_hand, tmp_path):
    """By the times of the bell from the first one on."""
    ends = [{}, {"enough": True}, {"exhausted": True}, {"alarms": (BASE,)}, {"leave": True}]
    heard = []
    for end in ends:
        seen = Timed()
        typed = (0.5, "a"), (6.0, "q")
        by_hand(arm(speed=1.0), *typed, guidance=Guidance({}, end), sound=True, seen=seen)
        heard.append(seen.rhythm)
        shutil.rmtree(tmp_path / "front")
    refused = Timed()
    by_hand(arm(speed=1.0), (0.1, "a"), (6.0, "q"), sound=True, seen=refused)
    heard.append(refused.rhythm)
    assert all(heard) and len(set(heard)) == len(heard), heard


def test_a_voice_says_what_the_bell_rings(arm, by_hand):
    said = []
    adviser = Guidance({}, {}, {"alarms": (BASE,)}, {"enough": True})
    typed = (0.5, "a"), (0.9, "a"), (2.2, "a"), (3.2, "k"), (3.8, "a"), (6.0, "q")
    by_hand(arm(speed=1.0), *typed, guidance=adviser, say=said.append)
    assert said[0] == "got 1" and said[1].startswith("refused: ")
    assert said[2:] == ["got 2", f"BASE MOVED: {BASE.text}", "got 3", "enough"]


BASE = Alarm("base", "BASE MOVED", "by 5.0 mm since sample 2", (2, 3))
BALL = Alarm("ball", "NOT SEATED", "sample 2 is 5.0 mm off", (2,))
FORGOTTEN = Alarm("socket", "WRONG SOCKET", "samples 2 to 3 lie in socket 1", (2, 3), 1)
READINGS = Alarm("joints", "JOINTS?", "0.5 m off since sample 2", (2, 3))
REMOUNTED = Alarm("flange", "BALL MOVED", "by 2.0 mm since sample 2", (2, 3))
TIPPED = Alarm("passing", "BASE TIPPED", "by 3.0 mm in samples 2 to 3", (2, 3))
EACH = (BASE, BALL, FORGOTTEN, READINGS, REMOUNTED, TIPPED)
ALARMS = {alarm.cause: alarm for alarm in EACH}


@by_table("cause", "key", "left", "moved")
def test_an_alarm_is_seen_and_heard_and_a_key_cures_it(arm, by_hand, cause, key, left, moved):
    alarm = ALARMS[cause]
    adviser = Guidance({}, {}, {}, {"alarms": (alarm,), "enough": True})
    typed = (0.5, "a"), (2.2, "a"), (3.8, "a"), (5.2, key), (5.6, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser, sound=True)
    assert [[s.number, s.socket] for s in outcome.session.live] == left
    assert bool(outcome.successor) == bool(moved)
    if outcome.successor:
        assert moved_numbers(outcome) == moved
        assert outcome.successor.metadata.readings_changed == (cause == "joints")
    assert f"{alarm.words}: {alarm.text}" in seen.alarms and seen.bells >= 1 + 3 + 1 + 2
    prompts = [view.prompt for view in seen.views]
    assert any(p.words == alarm.words and f"{key} " in p.reason for p in prompts)
    assert all(len(f" SOCKET 0  {p.text}") <= 80 for p in prompts if p.words == alarm.words)
    assert next(p.words for p in prompts if p.words in ("ENOUGH", alarm.words)) != "ENOUGH"


def test_a_quick_hand_hears_of_a_fault_as_well(arm, by_hand, virtual_time):
    """Advice on two samples that comes once there are three still tells their fault."""
    adviser, held = Guidance({}, {}, {"alarms": (BASE,)}, {}), []
    at_once = adviser.answer

    def answer():
        if not held and (said := at_once()):
            held.append((said, virtual_time.now() + 2.0 * (said.count == 2)))
        adviser.idle = not held or virtual_time.now() >= held[0][1]  # it computes on
        return held.pop()[0] if held and adviser.idle else None

    adviser.answer = answer
    typed = (0.5, "a"), (2.2, "a"), (3.8, "a"), (6.5, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    assert len(outcome.session.live) == 3
    assert f"{BASE.words}: {BASE.text}" in seen.alarms


def test_a_busy_computer_changes_sockets_and_what_is_left_of_older_advice_is_used(arm, by_hand):
    """Advice on no sample is all that ever comes; its route goes on in both sockets.

    The second of its poses is taken first: it is proposed no more.
    """
    route = ((0, (0.3, 0.1)), (0, (0.1, 0.2)), (0, (0.6, -0.4)), (1, (0.2, 0.5)), (0, (0.9, 0.9)))
    adviser = Guidance({"route": route, "target": route[0][1]})
    at_once, first = adviser.answer, []

    def answer():
        said = None if first else at_once()
        first.extend([said] if said else [])
        adviser.idle = not adviser.asked or len(adviser.asked) == 1
        return said

    adviser.answer = answer
    typed = (0.5, "a"), (2.2, "a"), (3.5, "s"), (3.9, "a"), (30.0, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser, block=2)
    assert outcome.session.counts == (2, 1) and len(adviser.asked) == 2
    shown = {}
    for view in seen.views:
        shown.setdefault((len(view.session.live), view.session.socket), view)
    proposed = {key: view.advice.target for key, view in shown.items() if view.advice}
    assert proposed[1, 0] == route[2][1] and proposed[2, 1] == route[3][1]
    assert shown[2, 0].session.turn_done and "SOCKET 1 NOW" in words_of(seen)
    assert not shown[2, 0].late and seen.views[-1].late


FAR, NEAR = (0.8, -0.9), (0.3, 0.3)


@pytest.mark.parametrize(
    ("aims", "confined"), [((FAR,), True), ((NEAR,), False), ((FAR, NEAR), False)]
)
def test_proposals_that_are_not_followed_come_from_where_the_samples_went(
    arm, by_hand, aims, confined
):
    """An arm that takes none of three in a row may stand in a narrow cell.

    The second aim is proposed until the adviser has thought anew.
    """
    adviser = Guidance({"target": aims[0], "route": tuple((0, aim) for aim in aims)})
    places = [(0.1 * k - 0.4, 0.3 - 0.05 * k) for k in range(4)]
    typed = [(0.5 + 1.6 * k, "a") for k in range(4)]
    _, seen = by_hand(arm(speed=1.0, places=places), *typed, (6.6, "q"), guidance=adviser)
    told = [len(q.samples) for q in adviser.asked if q.answers.confined]
    assert told[:1] == [3] * confined
    texts = [message.text for message in seen.views[-1].session.messages]
    assert any("--turn" in text for text in texts) == confined
    # what was followed is proposed no more, though the ball's mount led the hand beside it
    assert (NEAR in adviser.asked[-1].answers.followed) == (NEAR in aims)
    assert FAR not in adviser.asked[-1].answers.followed


def test_a_pose_that_cannot_be_taken_is_proposed_no_more(arm, by_hand):
    poses = [(0.3, 0.1), (0.1, 0.2), (0.6, -0.4)]
    said = {"route": tuple((0, pose) for pose in poses), "target": poses[0]}
    adviser = Guidance(said)
    typed = (0.5, "b"), (0.7, "b"), (1.2, "q")
    _, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    targets = [view.advice.target for view in seen.views if view.advice]
    assert list(dict.fromkeys(targets)) == poses
    assert adviser.asked[-1].answers.avoided == tuple(poses[:2])
    assert not adviser.asked[-1].answers.confined


def test_a_fail_is_told_with_its_reason_before_more_is_recorded(arm, by_hand):
    why = {"fails": "The arm came out 3 % longer than its model"}
    adviser = Guidance({}, why, {**why, "exhausted": True})
    typed = (0.5, "a"), (2.2, "a"), (3.8, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    said = [message.text for message in outcome.session.messages]
    assert said.count(f"solve would say FAIL: {why['fails']}") == 1
    shown = [view.prompt for view in seen.views if view.prompt.words == "SOLVE FAILS"]
    assert shown and {prompt.reason for prompt in shown} == {why["fails"]}


def test_advice_that_fails_ends_no_session(arm, by_hand):
    adviser = Guidance({})
    adviser.trouble = "it ended with status 1"
    outcome, seen = by_hand(arm(speed=1.0), (0.5, "a"), (1.8, "q"), guidance=adviser)
    assert len(outcome.session.live) == 1 and outcome.advice is None
    assert any("no advice any more" in m.text for m in seen.views[-1].session.messages)


def test_samples_that_alarms_took_back_go_along_with_a_base_that_moved(arm, by_hand):
    """The third, off by the same vector, shows that the second was sound after the base moved."""
    moved = replace(BASE, samples=(2, 3))
    adviser = Guidance({}, {}, {"alarms": (BALL,)}, {"alarms": (moved,)})
    typed = (0.5, "a"), (2.2, "a"), (3.0, "x"), (3.8, "a"), (4.6, "n"), (5.6, "q")
    outcome, _ = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    doubted = [sample.number for sample in adviser.asked[-1].answers.doubted]
    assert doubted == [2] and outcome.session.withdrawn == (2, 3)
    assert moved_numbers(outcome) == [2, 3]


@pytest.mark.parametrize("alarm", [BASE, BALL, READINGS, REMOUNTED])
def test_no_new_placement_takes_all_samples_of_one(arm, by_hand, tmp_path, alarm):
    """It is not offered, and its key begins none, with an alarm and without a sample."""
    whole = replace(alarm, samples=(1, 2), stays=False)
    adviser = Guidance({}, {}, {"alarms": (whole,)})
    typed = (0.3, "n"), (0.5, "a"), (2.2, "a"), (3.4, "n"), (5.6, "q")
    outcome, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    (reason,) = {view.prompt.reason for view in seen.views if view.alarm and not view.captured}
    assert "n " not in reason.partition(": ")[2].replace("again", "") and "k keep" in reason
    assert outcome.successor is None and outcome.session.counts == (2, 0)
    assert sum("no sample would stay" in text for text in seen.alarms) == 2
    assert not any(view.question for view in seen.views)
    assert [folder.name for folder in tmp_path.iterdir() if folder.is_dir()] == ["front"]


def test_a_kept_fault_stands_on_the_screen_and_the_session_still_ends(arm, by_hand):
    said = {"alarms": (BASE,), "exhausted": True, "fails": "The base moved", "fitted": True}
    adviser = Guidance({}, {}, {}, said)
    typed = (0.5, "a"), (2.2, "a"), (3.8, "a"), (5.2, "k"), (6.0, "q")
    _, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    assert adviser.asked[-1].answers.kept == (BASE,)
    last = seen.views[-1]
    assert last.prompt.words == "SOLVE FAILS" and last.kept == (BASE,)
    assert any("kept: BASE MOVED from sample 2 on; solve says FAIL" in str(line)
               for line in render(last, 80, 24))  # fmt: skip


def test_a_joint_that_slips_is_told_once_and_nothing_that_moves_after_it(arm, by_hand):
    slips = Alarm("model", "JOINT SLIPS", "b reads otherwise again and again", (1, 2))
    zero = Alarm("other", "LOST A ZERO", "b reads otherwise since sample 3", (3,))
    adviser = Guidance({}, {}, {"alarms": (slips,)}, {"alarms": (slips, BASE, zero)})
    typed = (0.5, "a"), (2.2, "a"), (3.4, "k"), (3.8, "a"), (5.6, "q")
    _, seen = by_hand(arm(speed=1.0), *typed, guidance=adviser)
    alarms = [view.alarm for view in seen.views if view.alarm]
    assert {alarm.words for alarm in alarms} == {"JOINT SLIPS"}
    assert list(alarms[0].answers) == ["finish", "keep"]
    assert seen.views[-1].session.counts == (3, 0) and not seen.views[-1].alarm


def test_a_fault_that_began_as_the_connection_came_back_says_so(arm, by_hand):
    """It is told as another arm, whose samples go into a placement of their own."""
    adviser = Guidance({}, {}, {"alarms": (replace(BASE, samples=(2,)),)})
    typed = (0.5, "a"), (3.8, "a"), (5.0, "n")
    outcome, seen = by_hand(arm("drop@1.2+1.0", speed=1.0), *typed, guidance=adviser)
    prompt = [view.prompt for view in seen.views if view.alarm][-1]
    assert prompt.words == "ANOTHER ARM?" and "n new" in prompt.reason
    assert prompt.reason.startswith("another arm, or its zeros: ")
    assert outcome.successor and outcome.successor.metadata.readings_changed


def test_another_arm_that_is_kept_is_told_no_more(arm, by_hand):
    adviser = Guidance({}, {}, {"alarms": (replace(BASE, samples=(2,)),)})
    typed = (0.5, "a"), (3.8, "a"), (5.0, "k"), (6.0, "q")
    _, seen = by_hand(arm("drop@1.2+1.0", speed=1.0), *typed, guidance=adviser)
    assert {view.alarm.words for view in seen.views if view.alarm} == {"ANOTHER ARM?"}
    assert not seen.views[-1].alarm


def test_a_stream_that_only_paused_is_no_other_arm(arm, by_hand):
    adviser = Guidance({}, {}, {"alarms": (replace(BASE, samples=(2,)),)})
    typed = (0.5, "a"), (3.8, "a"), (5.0, "n")
    source = arm("silent@1.2+1.0", speed=1.0)
    outcome, seen = by_hand(source, *typed, guidance=adviser, silence=2.0)
    assert any("the stream is back" in m.text for m in seen.views[-1].session.messages)
    assert {view.alarm.words for view in seen.views if view.alarm} == {BASE.words}
    assert outcome.successor and not outcome.successor.metadata.readings_changed


def test_poses_that_are_all_alike_are_told(arm, by_hand):
    places = [(0.1 + 0.05 * k, 0.1) for k in range(6)]
    typed = [(0.5 + 1.6 * k, "a") for k in range(6)]
    _, seen = by_hand(arm(speed=1.0, places=places), *typed, (10.0, "q"))
    assert any("all 6 poses lie within 25 degrees" in text for text in seen.alarms)


@pytest.mark.parametrize(("typed", "asked_again"), [("98.6", True), ("50.1", False)])
def test_a_distance_is_measured_again(arm, by_hand, tmp_path, typed, asked_again):
    """Both readings are kept; the session goes on by the last, or keeps what is confirmed."""
    alarm = Alarm("distance", "DISTANCE?", "the sockets come out 98.6 apart, not 50 mm", (1,))
    adviser = Guidance({}, {"alarms": (alarm,)})
    keys = (0.5, "a"), (1.4, "m"), (1.5, f"{typed}\r"), (2.4, "q")
    _, seen = by_hand(arm(speed=1.0), *keys, guidance=adviser)
    last = json.loads((tmp_path / "front/placement.json").read_text())
    metres = pytest.approx(float(typed) / 1e3)
    assert [reading["distance"] for reading in last["readings"]][-1] == metres
    assert last["distance"] == metres == adviser.asked[-1].answers.distance
    assert (seen.views[-1].alarm is not None) == asked_again

"""The drawing: everything that matters is on it, at any size, with and without colour."""

import io
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console, Group

from mukca.recorder import Sample
from mukca.recorder.session import Advice, OperatorContext, Session, View, prompt_for
from mukca.recorder.stream import JointLimits
from mukca.recorder.terminal import render

MOMENT = ("trouble", "moving", "contact", "captured", "question", "typed", "alarm")
JOINTS = tuple(JointLimits(f"panda_joint{i + 1}", -2.8, 2.8) for i in range(7))


def session(count=12, sockets=2, joints=JOINTS):
    made = Session(joints, sockets=sockets)
    for k in range(count):
        position = tuple(0.05 * k * (i - 3) for i in range(len(joints)))
        spread = tuple(1e-5 * (i + 1) for i in range(len(joints)))
        sample = Sample(position, 0, number=k + 1, time=1.7e9, states=300, spread=spread)
        made = made.captured(sample)
    return made


def view(made=None, **more):
    """A view; what to do now follows from what a moment may say."""
    made = made or session()
    position = more.pop("position", (0.3,) * len(made.joints))
    said = {f: more.pop(f) for f in MOMENT if f in more}
    ready = prompt_for(OperatorContext(made, position, **said))
    facts = {"position": position, "rate": 1000.0, "age": 0.002, **more}
    return View(made, "panda  mock:hand  data/front", ready, **facts)


def drawn(shown, width=80, height=24, plain=False, colour=None):
    console = Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=colour
    )
    with console.capture() as capture:
        console.print(Group(*render(shown, width, height, plain=plain)))
    return capture.get().rstrip("\n").split("\n")


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    width=st.integers(1, 220),
    height=st.integers(1, 60),
    joints=st.integers(1, 14),
    sockets=st.integers(1, 10),
    count=st.integers(0, 40),
    helps=st.booleans(),
    plain=st.booleans(),
    trouble=st.none() | st.text(max_size=300),
    message=st.text(max_size=300),
)
def test_it_fits_any_terminal(
    width, height, joints, sockets, count, helps, plain, trouble, message
):
    made = session(count, sockets, tuple(JointLimits(f"j{i}", -1, 1) for i in range(joints)))
    shown = view(made.with_message(message, alarm=True), help=helps, trouble=trouble)
    lines = render(shown, width, height, plain=plain)
    assert all(line.cell_len <= width for line in lines)
    fits = width >= 60 and height >= joints + 7
    assert len(lines) == (height if fits else 1)


@pytest.mark.parametrize("plain", [False, True])
def test_all_that_is_needed_is_on_80_by_24(plain):
    made = (
        session()
        .with_message("captured sample 12")
        .with_message("refused: still moving", alarm=True)
    )
    shown = "\n".join(drawn(view(made, moving="still moving: panda_joint4 by 1.2°"), plain=plain))
    for needed in (
        "SOCKET 0",
        "HOLD",
        "still moving: panda_joint4",
        "0: 12/30",
        "1:  0/30",
        "stream 1000 Hz",
        "last state 2 ms ago",
        "missed 0",
        *(joint.name for joint in JOINTS),
        "17.2",
        "sample  12",
        "sample   8",
        "spread 0.0040",
        "captured sample 12",
        "! refused: still moving",
        "space capture",
    ):
        assert needed in shown, needed
    assert plain <= shown.isascii()


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({}, "PRESS: space captures sample 13"),
        ({"contact": "elbow exerts +6 N m beyond gravity"}, "LET GO"),
        ({"trouble": "the stream is silent", "contact": "x"}, "WAIT"),
        ({"drops": 2}, "connection lost 2x"),
        ({"missed": 7}, "missed 7"),
        ({"age": math.inf}, "no state yet"),
        ({"age": 3.21}, "last state 3.2 s ago"),
        ({"scripted": True}, "keys by script"),
        ({"help": True}, "undo the last capture"),
        ({"typed": "delete sample: 1_"}, "WHICH?: delete sample: 1_"),
        ({"position": None}, "panda_joint1"),
    ],
)
def test_what_holds_now_is_said(more, says):
    assert any(says in line for line in drawn(view(**more)))


def test_what_is_continued_is_asked_in_a_small_window_too():
    card = (
        "Continues 2 in socket 0, 1 in socket 1; the last 2026-11-22 02:33; in /data/arm/front",
        "Sockets 50 mm apart. The ball was last in socket 1.",
        "Is the base where it was?",
    )
    shown = " ".join(
        " ".join(drawn(view(question="GO ON?: y go on", resume_summary=card), 60, 14)).split()
    )
    assert "y go on" in shown
    assert all(line in shown for line in card)


def test_a_long_reason_has_the_line_to_itself():
    reason = "the arm stands where it stood for sample 2 in socket 1"
    assert any(reason[:46] in line for line in drawn(view(trouble=reason), 60, 14))
    assert any("WAIT: the arm stands" in line for line in drawn(view(trouble=2 * reason), 80, 24))


def test_all_of_the_help_is_on_80_by_24_and_its_keys_on_60():
    shown = drawn(view(help=True))
    assert not any("…" in line for line in shown)
    for key in (
        "space, a    capture",
        "x, l        delete",
        "?           this help",
        "Ctrl-C ends",
    ):
        assert any(key in line for line in shown), key
    narrow = drawn(view(help=True), 60, 24)
    assert any(
        "n           new placement, if a sample shows a moved base" in line for line in narrow
    )


def test_the_bar_shows_limits_captures_of_both_sockets_target_and_place():
    joint = (JointLimits("a", math.radians(-100), math.radians(100)),)
    made = Session(joint)
    for number, (degrees, socket) in enumerate(((-50, 0), (0, 0), (75, 1)), start=1):
        made = made.captured(Sample((math.radians(degrees),), socket, number=number))
    advice = Advice(3, 0, 4e-4, 3e-4, target=(math.radians(-80),))
    line = next(
        x for x in drawn(view(made, position=(math.radians(50),), advice=advice)) if "├" in x
    )
    bar = line[line.index("├") + 1 : line.index("┤")]
    shares = {mark: [i / (len(bar) - 1) for i, c in enumerate(bar) if c == mark] for mark in "▮╷◆┃"}
    assert shares["▮"] == pytest.approx([0.25, 0.5], abs=0.02)
    assert shares["╷"] == pytest.approx([0.875], abs=0.02)
    assert shares["◆"] == pytest.approx([0.1], abs=0.02)
    assert shares["┃"] == pytest.approx([0.75], abs=0.02)
    assert "-100.0°├" in line and "┤100.0°" in line and line.endswith("50.0°")


def test_a_joint_without_limits_has_a_bar_of_one_turn():
    assert any("-180.0°├" in line for line in drawn(view(Session((JointLimits("wheel"),)))))


def test_a_prismatic_joint_is_shown_in_millimetres():
    made = Session((JointLimits("rail", 0, 0.5, prismatic=True),))
    assert any(
        "0.0 mm├" in x and x.endswith("123.0 mm") for x in drawn(view(made, position=(0.123,)))
    )


def test_the_active_socket_is_told_by_more_than_colour():
    assert "SOCKET 0" in drawn(view())[4] and "SOCKET 1" in drawn(view(session().switched(1)))[4]


@pytest.mark.parametrize(("width", "height"), [(60, 14), (60, 15), (80, 24)])
def test_a_refusal_and_all_joints_are_there_in_a_small_window(width, height):
    why = (
        "refused: the arm stands where it stood for sample 12 in socket 0: move the ball to "
        "socket 1 first"
    )
    lines = drawn(view(session().with_message(why, alarm=True)), width, height)
    assert all(any(joint.name in line for line in lines) for joint in JOINTS)
    told = " ".join(line.removeprefix(" ! ") for line in lines if line.startswith(" !"))
    assert told == why


@pytest.mark.parametrize(("width", "height"), [(59, 14), (60, 13)])
def test_a_window_that_is_too_small_says_what_is_needed(width, height):
    assert drawn(view(), width, height) == [f"needs 60 x 14, has {width} x {height}: PRESS"]


@pytest.mark.parametrize(
    ("words", "more"),
    [
        ("MOVE", {"moving": "still moving", "position": (1.0,) * 7}),
        ("PRESS", {}),
        ("GOT 17", {"captured": 17}),
        ("WHICH?", {"typed": "delete"}),
        ("GO ON?", {"question": "GO ON?: y go on"}),
        ("FJQYZ", {"question": "FJQYZ: y go on"}),
        ("WAIT", {"trouble": "silent"}),
        ("LET GO", {"contact": "elbow"}),
    ],
)
def test_the_banner_is_three_rows_of_one_colour_and_fits_the_smallest_window(words, more):
    shown = view(**more)
    lines = render(shown, 60, 14)
    rows = [line for line in lines if str(line.style).startswith("bold white on ")]
    assert len(rows) == 3 and len({str(row.style) for row in rows}) == 1, words
    for row in rows:
        assert row.cell_len == 60 and row.plain.endswith(" ") and row.plain.strip()


def test_the_gauge_holds_what_is_predicted_against_the_goal():
    advice = Advice(12, 0, 4.3e-4, 3e-4, True, 1.2e-4, 1e-4, 2e-4, 0.05003)
    for width in (80, 120):
        line = next(line for line in drawn(view(advice=advice), width) if "predicted" in line)
        for part in (
            "predicted 0.43 ██",
            "goal 0.30",
            "last 0.12",
            "mean 0.10",
            "+0.02 %",
            "50.03",
        ):
            assert part in line
    early = drawn(view(advice=replace(advice, count=2)))
    assert not any("predicted" in line for line in early)


def test_the_newest_message_is_whole_and_last():
    made = session().with_message("older").with_message("word " * 20 + "end", alarm=True)
    lines = [line for line in drawn(view(made)) if line.startswith((" !", " >"))]
    assert lines[0] == " > older" and lines[-1].endswith("end") and len(lines) == 3

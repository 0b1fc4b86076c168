"""The drawing: everything that matters is on it, at any size, with and without colour."""

import io
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from mukca.recorder.samples import Sample
from mukca.recorder.screen import HELP, View, render
from mukca.recorder.session import JointLimits, Session

JOINTS = tuple(JointLimits(f"panda_joint{i + 1}", -2.8, 2.8) for i in range(7))


def session(count: int = 12, sockets: int = 2, joints: tuple[JointLimits, ...] = JOINTS) -> Session:
    made = Session(joints, sockets=sockets)
    for k in range(count):
        position = tuple(0.05 * k * (i - 3) for i in range(len(joints)))
        spread = tuple(1e-5 * (i + 1) for i in range(len(joints)))
        sample = Sample(position, 0, number=k + 1, time=1.7e9, states=300, spread=spread)
        made = made.captured(sample)
    return made


def view(made: Session | None = None, **more: object) -> View:
    made = made or session()
    facts = {"position": (0.3,) * len(made.joints), "rate": 1000.0, "age": 0.002, **more}
    return View(made, "panda  mock:hand  data/front", **facts)  # pyright: ignore


def drawn(
    shown: View, width: int = 80, height: int = 24, plain: bool = False, colour: str | None = None
) -> list[str]:
    console = Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=colour
    )
    with console.capture() as capture:
        console.print(render(shown, width, height, plain=plain))
    return capture.get().rstrip("\n").split("\n")


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
) -> None:
    made = session(count, sockets, tuple(JointLimits(f"j{i}", -1, 1) for i in range(joints)))
    shown = view(made.with_message(message, alarm=True), help=helps, trouble=trouble)
    group = render(shown, width, height, plain=plain)
    assert all(line.cell_len <= width for line in group.renderables)
    assert len(group.renderables) in (1, height)


@pytest.mark.parametrize("plain", [False, True])
def test_all_that_is_needed_is_on_80_by_24(plain: bool) -> None:
    made = (
        session()
        .with_message("captured sample 12")
        .with_message("refused: still moving", alarm=True)
    )
    shown = "\n".join(drawn(view(made, trouble="still moving: panda_joint4 by 1.2°"), plain=plain))
    for needed in (
        "SOCKET 0",
        "WAIT",
        "still moving: panda_joint4",
        "12 of 30 captured",
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
        ({}, "STILL: press space"),
        ({"push": "elbow exerts +6 N m beyond gravity"}, "LET GO of the arm"),
        ({"trouble": "the stream is silent", "push": "x"}, "WAIT"),
        ({"drops": 2}, "connection lost 2x"),
        ({"missed": 7}, "missed 7"),
        ({"age": math.inf}, "no state yet"),
        ({"age": 3.21}, "last state 3.2 s ago"),
        ({"scripted": True}, "keys by script"),
        ({"help": True}, "undo the last capture"),
        ({"position": None}, "panda_joint1"),
    ],
)
def test_what_holds_now_is_said(more: dict[str, object], says: str) -> None:
    assert any(says in line for line in drawn(view(**more)))


def test_all_of_the_help_is_on_80_by_24() -> None:
    shown = drawn(view(help=True))
    assert not any("…" in line for line in shown)
    for line in HELP.splitlines():
        assert f" {line}".rstrip() in [row.rstrip() for row in shown]


def test_the_bar_shows_limits_range_and_place() -> None:
    joint = (JointLimits("a", math.radians(-100), math.radians(100)),)
    made = Session(joint)
    for number, degrees in enumerate((-50, 0), start=1):
        made = made.captured(Sample((math.radians(degrees),), 0, number=number))
    line = next(x for x in drawn(view(made, position=(math.radians(50),))) if "├" in x)
    bar = line[line.index("├") + 1 : line.index("┤")]
    share = {mark: bar.index(mark) / len(bar) for mark in "▒┃"}
    assert share["▒"] == pytest.approx(0.25, abs=0.02)
    assert (bar.rindex("▒") + 1) / len(bar) == pytest.approx(0.5, abs=0.02)
    assert share["┃"] == pytest.approx(0.75, abs=0.02)
    assert "-100.0°├" in line and "┤100.0°" in line and line.endswith("50.0°")


def test_a_joint_without_limits_has_a_bar_of_one_turn() -> None:
    assert any("-180.0°├" in line for line in drawn(view(Session((JointLimits("wheel"),)))))


def test_a_prismatic_joint_is_shown_in_millimetres() -> None:
    made = Session((JointLimits("rail", 0, 0.5, prismatic=True),))
    assert any(
        "0.0 mm├" in x and x.endswith("123.0 mm") for x in drawn(view(made, position=(0.123,)))
    )


def test_the_active_socket_is_told_by_more_than_colour() -> None:
    first = drawn(view(session().switched(0)))
    second = drawn(view(session().switched(1)))
    assert first[1:4] != second[1:4]
    assert "SOCKET 1" in second[2]
    assert drawn(view(), colour="256")[1] != drawn(view(session().switched(1)), colour="256")[1]


def test_the_newest_message_is_whole_and_last() -> None:
    made = session().with_message("older").with_message("word " * 20 + "end", alarm=True)
    lines = [line for line in drawn(view(made)) if line.startswith((" !", " >"))]
    assert lines[0] == " > older" and lines[-1].endswith("end") and len(lines) == 3

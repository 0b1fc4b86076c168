"""The drawing: everything that matters is on it, at any size, with and without colour.

The screens stand in the folder beside; after a change that is meant run this with
``MUKCA_KEEP_PAGES=1``, and look at them.
"""

import io
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from cases import by_table
from hypothesis import given, settings
from hypothesis import strategies as st
from kept import compare
from rich.console import Console, Group

from mukca.recorder import Sample
from mukca.recorder.session import CURES, KEYS, Advice, Alarm, Session, View
from mukca.recorder.stream import JointLimits
from mukca.recorder.terminal import MOVED, RESUME, TypedLine, keys_with, render

JOINTS = tuple(JointLimits(f"panda_joint{i + 1}", -2.8, 2.8) for i in range(7))


def session(count=12, sockets=2, joints=JOINTS):
    made = Session(joints, sockets=sockets)
    for k in range(count):
        position = tuple(0.05 * k * (i - 3) for i in range(len(joints)))
        spread = tuple(1e-5 * (i + 1) for i in range(len(joints)))
        sample = Sample(position, 0, number=k + 1, states=300, spread=spread)
        made = made.captured(sample)
    return made


def view(made=None, **more):
    made = made or session()
    facts = {"position": (0.3,) * len(made.joints), "rate": 1000.0, "age": 0.002, **more}
    return View(made, title="panda  mock:hand  data/front", **facts)


def drawn(shown, width=80, height=24, plain=False, colour=None):
    console = Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=colour
    )
    with console.capture() as capture:
        console.print(Group(*render(shown, width, height, ascii_only=plain)))
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
    lines = render(shown, width, height, ascii_only=plain)
    assert all(line.cell_len <= width for line in lines)
    assert len(lines) == height


def degrees(*angles):
    """A session of one joint of +-100 degrees, captured at these in socket 0, the last in 1."""
    made = Session((JointLimits("a", math.radians(-100), math.radians(100)),))
    for number, angle in enumerate(angles, start=1):
        socket = int(number == len(angles))
        made = made.captured(Sample((math.radians(angle),), socket, number=number, states=1))
    return made


ADVICE = Advice(12, 0, 4.3e-4, 3e-4, True, 1.2e-4, 1e-4, 2e-4, 0.05003)
ADVICE_OF = {"gauge": ADVICE, "gauge wide": ADVICE, "gauge early": replace(ADVICE, count=2)}
ADVICE_OF["bar"] = Advice(3, 0, 4e-4, 3e-4, target=(math.radians(-80),))
SESSIONS = {
    "other socket": session().switched(1),
    "bar": degrees(-50, 0, 75),
    "endless joint": Session((JointLimits("wheel"),)),
    "prismatic joint": Session((JointLimits("rail", 0, 0.5, prismatic=True),)),
}
"""Those of some screens; the others show twelve samples of seven joints."""


@by_table("name", "size", "messages", "more")
def test_a_screen_is_as_it_was(name, size, messages, more):
    made = SESSIONS.get(name, session())
    for text, alarm in messages:
        made = made.with_message(text, alarm=alarm)
    shown = view(made, advice=ADVICE_OF.get(name), **more)
    for plain in (False, True) if name in ("whole", "bar") else (False,):
        lines = [line.rstrip() for line in drawn(shown, *size, plain=plain)]
        assert plain <= "".join(lines).isascii()
        folder = Path(__file__).parent / "screens"
        compare(folder / f"{name}{', ascii' * plain}.txt", lines)


@pytest.mark.parametrize(("width", "height"), [(59, 14), (60, 13)])
def test_a_window_that_is_too_small_says_what_is_needed(width, height):
    lines = [line.strip() for line in drawn(view(), width, height)]
    assert lines[0].startswith("SOCKET 0  PRESS: space captures")
    assert f"The whole screen needs 60 x 14, not {width} x {height}." in " ".join(lines)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 2), (20, 8), (40, 24)])
def test_a_small_window_still_has_the_next_step_and_the_last_message(width, height):
    made = session().with_message("older").with_message("refused: still moving", alarm=True)
    lines = [line.rstrip() for line in drawn(view(made), width, height)]
    assert len(lines) <= height and max(map(len, lines)) <= width
    if width >= 20:
        words = " ".join(" ".join(lines).split())
        assert "SOCKET 0 PRESS: space captures" in words and " in socket 0, 0 in socket 1." in words
    assert ("! refused: still moving" in " ".join(lines)) == (width == 40)


def test_long_names_of_joints_stay_apart_where_there_is_little_room():
    joints = tuple(JointLimits(f"openarm_right_joint{i}", -1, 1) for i in range(1, 8))
    lines = drawn(view(session(0, joints=joints)), 60, 20)
    assert all(any(f"right_joint{i} " in line for line in lines) for i in range(1, 8))


@pytest.mark.parametrize("width", [60, 80])
def test_no_fact_is_cut_in_its_midst(width):
    """The stream's line has fewer words where there is less room, and the gauge a second line."""
    shown = view(advice=ADVICE, drops=2, discarded=31, missed=12)
    lines = [line.strip() for line in drawn(shown, width, 24)]
    assert any(line.endswith("lost 2x") for line in lines), lines
    assert any(line.endswith("sockets 50.03") for line in lines), lines
    assert not any("…" in line for line in lines[6:10]), lines


def test_advice_says_how_old_it_is():
    older = view(session(17), advice=ADVICE)
    assert any("5 samples ago" in line for line in drawn(older))
    assert not any("samples ago" in line for line in drawn(view(session(14), advice=ADVICE)))
    assert any("the computer is busy" in line for line in drawn(view(late=True)))


def test_enough_says_what_for_and_what_else_is_asked():
    enough = Advice(12, 0, 8e-4, 9e-4, enough=True)

    def reason(advice, *, measured=True):
        prompt = view(replace(session(), measured=measured), advice=advice).prompt
        assert prompt.words == "ENOUGH" and "q finishes" in prompt.reason
        return prompt.reason

    assert "for PASS record another place" in reason(enough)
    assert "PASS" not in reason(replace(enough, alone=False))
    assert "PASS" not in reason(replace(enough, unit="mrad"))
    near = replace(enough, near_only=True)
    assert "for this place" in reason(near) and "train on two: n" in reason(near)
    assert reason(near, measured=False).startswith("m types the sockets' distance")


def test_the_joints_that_turn_most_are_read_from_afar():
    """While a hand leads, in whole degrees; where a key is asked for, the word stands there."""
    turned = Advice(3, 0, 4e-4, 3e-4, target=(0.3, 0.3 - 1.22, *[0.35] * 4, 0.3 + 0.62))
    leading = view(advice=turned, fast=True, moving="it moves")
    assert (leading.large, leading.prompt.words) == ("J2 -70 J7 +36", "MOVE")
    assert view(advice=turned).large == "PRESS"
    assert view(fast=True, moving="it moves").large == "MOVE"


def test_a_configuration_outside_the_limits_is_no_pose_to_move_on_from():
    outside = view(position=(*[0.3] * 3, 2.9, *[0.3] * 3)).prompt
    assert outside.words == "OUT OF LIMITS" and "panda_joint4 reads 166.2°" in outside.reason
    assert view(implausible="puts the ball far away").prompt.words == "MOVE"


def test_a_question_of_an_alarm_has_one_mark():
    loose = Alarm("other", "LOOSE", "all samples scatter: are ball and base tight?")
    assert view(alarm=loose).prompt.reason.endswith("are ball and base tight? k keep")


def test_the_page_s_address_stands_in_the_header_and_in_the_help():
    url = "http://192.168.1.20:41234/abcdefghjkmn/"
    assert url in drawn(view(page=url), 60, 24)[0]
    assert any(url in line for line in drawn(view(page=url, help=True)))


@pytest.mark.parametrize("more", [{}, {"captured": 17}, {"trouble": "silent"}])
def test_the_banner_is_three_rows_of_one_colour(more):
    lines = render(view(**more), 60, 14)
    rows = [line for line in lines if str(line.style).startswith("bold white on ")]
    assert len(rows) == 3 and len({str(row.style) for row in rows}) == 1
    assert all(row.cell_len == 60 and row.plain.strip() for row in rows)


@pytest.mark.parametrize(
    ("asked", "keys"),
    [
        ({}, "space capture  u undo  r redo  s next socket  q finish  ? all keys"),
        (
            {"question": "MOVED?: elsewhere now?   y new placement   n go on"},
            "y new placement   n go on",
        ),
        (
            {"typed": "relabel: sample, blank, socket: 12  1_   Enter does it, q leaves"},
            "Enter does it, q leaves",
        ),
    ],
)
def test_the_bottom_row_has_the_keys_that_do_something(asked, keys):
    assert drawn(view(**asked))[-1].strip() == keys


NAMES = {f"F{number}": key for number, key in enumerate("aurxlmsbq?y", 1)}
NAMES |= {"Home": "n", "End": "k", "F1": "space"}
"""Further names of keys, each with that of the default."""
END = Advice(12, 0, 4e-4, 3e-4)
SHOWN = [
    {"advice": replace(END, leave=True)},
    {"advice": replace(END, exhausted=True)},
    {"advice": replace(END, enough=True)},
    {"advice": replace(END, enough=True, near_only=True)},
    {"advice": replace(END, enough=True), "measured": False},
    {"advice": replace(END, target=(0.9,) * 7)},
    {"target": 0},
    {"paused": True},
    {"help": True},
    *({"alarm": Alarm(cause, "BASE MOVED", "by 5 mm", (2,))} for cause in CURES),
    *({"question": question} for question in (RESUME, MOVED)),
    {"typed": TypedLine("measure").text},
    {"help": True, "typed": TypedLine("delete").text},
]


@pytest.mark.parametrize("more", SHOWN)
def test_every_text_names_the_keys_that_the_operator_chose(more):
    """With the default keys in the place of the others each text is as it is without a choice."""
    settings = {name: more[name] for name in ("target", "measured") if name in more}
    rest = {name: value for name, value in more.items() if name not in settings}
    chosen = keys_with(
        f"{KEYS[key if key != 'space' else 'a']}={name}" for name, key in NAMES.items()
    )
    texts = []
    for keys in (chosen, KEYS):
        made = replace(session(), keys=keys, **settings).with_message("{undo} takes it back")
        shown = view(made, **rest)
        lines = drawn(shown, 200, 40)[4:]
        texts.append("\n".join([shown.large, shown.prompt.text, *lines]))
        assert "{" not in texts[-1]
    renamed, default = texts
    if more.get("help"):
        assert all(name in renamed for name in NAMES if KEYS[NAMES[name]] not in ("yes", "keep"))
        return
    assert not re.findall(r"(?<![\w'])([b-z]|space)(?![\w'])", renamed)
    back = re.sub(r"(?i)\b(F\d+|Home|End)\b", lambda match: NAMES[match[0].capitalize()], renamed)
    assert back.lower() == default.lower()

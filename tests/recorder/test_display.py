"""What reaches the terminal: whole screens where needed, changed lines else, nothing when gone."""

import io
import os
import re
import select
import threading
import time
from dataclasses import replace

import pyte
import pytest
from rich.console import Console

from mukca.recorder import Sample
from mukca.recorder.session import Advice, Session, View
from mukca.recorder.stream import JointLimits
from mukca.recorder.terminal import Lines, Screen

SESSION = Session((JointLimits("elbow", -1, 1),))
VIEW = View(SESSION, (0.1,), "arm", rate=1000.0, age=0.001, scripted=True)


class Terminal:
    """A pseudo-terminal that knows no size, and a screen on it."""

    def __init__(self, encoding="utf-8"):
        self.master, slave = os.openpty()
        self.stream = open(slave, "w", encoding=encoding)  # noqa: SIM115, PTH123
        self.screen = Screen(Console(file=self.stream, force_terminal=True))

    def written(self):
        """All that was written by now: up to a mark, however late it is handed over."""
        self.stream.write("\0")
        self.stream.flush()
        text = b""
        while not text.endswith(b"\0"):
            text += os.read(self.master, 65536)
        return text[:-1].decode()

    def close(self):
        self.stream.close()
        os.close(self.master)


@pytest.fixture
def terminal():
    made = Terminal()
    yield made
    made.close()


def rows(written):
    return [int(row) for row in re.findall(r"\x1b\[(\d+);1H", written)]


def test_a_terminal_without_a_size_gets_80_by_24(terminal):
    with terminal.screen as screen:
        screen.show(VIEW)
        assert rows(terminal.written()) == list(range(1, 25))


def test_only_changed_lines_are_written_again(terminal):
    with terminal.screen as screen:
        screen.show(VIEW)
        terminal.written()
        screen.show(VIEW)
        assert terminal.written() == ""
        screen.show(replace(VIEW, missed=3))
        assert rows(terminal.written()) == [7]


def test_a_terminal_that_takes_nothing_in_holds_nobody_up(terminal):
    """What was begun is written whole before a new frame; what the frames between showed is not."""
    with terminal.screen as screen:
        begun = time.monotonic()
        for missed in range(2000):  # a thousand times more than a terminal takes in
            screen.show(replace(VIEW, missed=missed, title="x" * (missed % 70)))
        screen.bell()
        assert time.monotonic() - begun < 20
        text = b""
        while select.select([terminal.master], [], [], 0.2)[0]:
            text += os.read(terminal.master, 65536)
            screen.show(replace(VIEW, missed=7777))
        terminal.screen.show(replace(VIEW, missed=7777))
        text = text.decode()
    assert "missed 1999" not in text and text.count("\a") == 1
    shown = pyte.Screen(80, 24)
    pyte.Stream(shown).feed(text)
    assert any("missed 7777" in line for line in shown.display)


def test_the_end_waits_for_no_frame_that_a_slow_line_has_not_carried(terminal):
    """Nor does one come after it, though a sequence was cut."""
    leave = "\x18\x1b[?25h\x1b[?1049l"
    reader = threading.Timer(5.0, lambda: os.read(terminal.master, 65536))
    with terminal.screen as screen:
        for missed in range(2000):
            screen.show(replace(VIEW, missed=missed, title="x" * (missed % 70)))
        reader.start()
        begun = time.monotonic()
    assert time.monotonic() - begun < 2
    reader.cancel()
    assert terminal.written().endswith(leave)


def test_a_terminal_without_unicode_gets_ascii():
    terminal = Terminal("ascii")
    with terminal.screen as screen:
        screen.show(VIEW)
        assert "SOCKET 0" in (text := terminal.written()) and text.isascii()
    terminal.close()


def test_without_a_terminal_messages_are_lines():
    text = io.StringIO()
    session = VIEW.session.with_message("first").with_message("[b]second[/b]", alarm=True)
    with Lines(Console(file=text)) as lines:
        lines.show(replace(VIEW, session=session))
        lines.show(replace(VIEW, session=session))
        lines.show(replace(VIEW, session=session.with_message("third")))
        lines.bell()
    with Lines(Console(file=text), brief=True) as lines:
        lines.show(replace(VIEW, session=session))
    assert text.getvalue() == "first\n! [b]second[/b]\nthird\n! [b]second[/b]\n"


def test_without_a_terminal_what_to_do_is_a_line_each_time_it_changes():
    text = io.StringIO()
    by_hand = replace(VIEW, scripted=False)
    with Lines(Console(file=text)) as lines:
        lines.show(by_hand)
        lines.show(replace(by_hand, age=0.1))
        for more in ({"moving": "still moving"}, {"typed": "delete: _"}, {"typed": "delete: 2_"}):
            lines.show(replace(by_hand, **more))
    keys, *told = text.getvalue().splitlines()
    assert keys.startswith("space capture")
    assert told == [
        "socket 0  PRESS: space captures sample 1, with the ball in socket 0",
        "socket 0  HOLD: still moving",
        "socket 0  WHICH?: delete: _",
        "socket 0  WHICH?: delete: 2_",
    ]


def test_a_simple_terminal_gets_one_line_for_each_change():
    """The same advice comes anew with each sample, and a capture is a message already."""
    text = io.StringIO()
    by_hand = replace(VIEW, scripted=False, advice=Advice(3, 0, 4e-4, 3e-4, target=(0.9,)))
    with Lines(Console(file=text, width=200)) as lines:
        lines.show(by_hand)
        before = len(text.getvalue().splitlines())
        session = SESSION.with_message("captured sample 1")
        lines.show(replace(by_hand, session=session, captured=1))
        lines.show(
            replace(by_hand, session=session, advice=Advice(3, 0, 4e-4, 3e-4, target=(0.9,)))
        )
        assert text.getvalue().splitlines()[before:] == ["captured sample 1"]
        lines.show(
            replace(by_hand, session=session, advice=Advice(4, 0, 3e-4, 3e-4, target=(0.9,)))
        )
    assert len(text.getvalue().splitlines()) == before + 2


def test_a_simple_terminal_says_press_for_each_sample_of_a_quick_hand():
    """The arm rests at the next pose while the last capture is still told."""
    text = io.StringIO()
    first = replace(VIEW, scripted=False)
    second = replace(first, session=SESSION.captured(Sample((0.9,), 0, number=1)))
    with Lines(Console(file=text, width=200)) as lines:
        for view in (first, replace(second, captured=1), second, second):
            lines.show(view)
    told = [line for line in text.getvalue().splitlines() if "PRESS" in line]
    assert len(told) == 2 and told[1].endswith("space captures sample 2")


def test_a_simple_terminal_gets_no_line_for_an_arm_on_its_way():
    text = io.StringIO()
    advice = Advice(3, 0, 4e-4, 3e-4, target=(0.9,))
    with Lines(Console(file=text, width=200)) as lines:
        lines.show(replace(VIEW, advice=advice))
        before = text.getvalue()
        lines.show(replace(VIEW, position=(0.5,), advice=advice))
        assert text.getvalue() == before and "elbow up by 46" in before
        lines.show(replace(VIEW, advice=replace(advice, target=(-0.2,))))
    assert "elbow down by 17" in text.getvalue()


def test_each_joint_that_must_move_is_named_in_the_order_of_the_chain():
    session = Session(tuple(JointLimits(name, -1, 2) for name in ("base", "elbow", "wrist")))
    advice = Advice(3, 0, 4e-4, 3e-4, target=(-0.2, 0.01, 1.2), lift=True)
    text = io.StringIO()
    with Lines(Console(file=text, force_terminal=True, color_system=None, width=200)) as lines:
        lines.show(replace(VIEW, session=session, position=(0.0, 0.0, 0.0), advice=advice))
    assert "lift the ball out for this one: base down by 11°, wrist up by 69°" in text.getvalue()

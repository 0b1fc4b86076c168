"""Keys from a real pseudo-terminal: each press counts once, and the terminal is given back."""

import contextlib
import os
import select

import pytest
from cases import by_table

from mukca.recorder.terminal import Keyboard


@pytest.fixture
def pty():
    master, slave = os.openpty()
    yield master, slave
    for descriptor in (master, slave):
        with contextlib.suppress(OSError):
            os.close(descriptor)


def pressed(keyboard, master, keys, wait=5.0):
    os.write(master, keys)
    ready, _, _ = select.select([keyboard], [], [], wait)
    return keyboard.read() if ready else []


def test_keys_come_at_once_and_unseen(pty):
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"a") == ["a"]
        assert pressed(keyboard, master, b" 1q") == ["space", "1", "q"]
    ready, _, _ = select.select([master], [], [], 0.1)
    assert not ready, "the terminal echoed the keys"


def test_what_was_typed_blindly_does_not_reach_the_shell(pty):
    master, slave = pty
    with Keyboard(slave):
        os.write(master, b"rm -r *\n")
        select.select([slave], [], [], 5.0)
    assert not select.select([slave], [], [], 0.1)[0]


@by_table("sequence", "names")
def test_special_keys_have_names(pty, sequence, names):
    """No other special key passes for a letter, nor do bytes that are no text.

    Keys that would freeze the screen are off.
    """
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, sequence.encode("latin-1") + b"q") == [*names, "q"]
        os.write(slave, b"seen")
        assert os.read(master, 10) == b"seen"


def test_a_sequence_that_comes_in_two_parts_is_no_letter_either(pty, virtual_time):
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"s\x1b[") == ["s"]
        assert pressed(keyboard, master, b"Aq") == ["Up", "q"]


def test_escape_alone_does_not_swallow_the_next_key(pty, virtual_time):
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"\x1b") == []
        virtual_time.sleep(0.15)
        assert pressed(keyboard, master, b"a") == ["a"]

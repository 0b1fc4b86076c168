"""Keys from a real pseudo-terminal: each press counts once, and the terminal is given back."""

import contextlib
import os
import select
import termios
import time
from collections.abc import Iterator

import pytest

from mukca.recorder.terminal import Keyboard
from mukca.recorder.terminal.keyboard import HangUp


@pytest.fixture
def pty() -> Iterator[tuple[int, int]]:
    master, slave = os.openpty()
    yield master, slave
    for descriptor in (master, slave):
        with contextlib.suppress(OSError):
            os.close(descriptor)


def pressed(keyboard: Keyboard, master: int, keys: bytes, wait: float = 5.0) -> list[str]:
    os.write(master, keys)
    ready, _, _ = select.select([keyboard], [], [], wait)
    return keyboard.read() if ready else []


def test_keys_come_at_once_and_unseen(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"a") == ["a"]
        assert pressed(keyboard, master, b" 1q") == ["space", "1", "q"]
    ready, _, _ = select.select([master], [], [], 0.1)
    assert not ready, "the terminal echoed the keys"


@pytest.mark.parametrize("fails", [False, True])
def test_the_terminal_is_given_back(pty: tuple[int, int], fails: bool) -> None:
    _, slave = pty
    before = termios.tcgetattr(slave)
    try:
        with Keyboard(slave):
            assert termios.tcgetattr(slave) != before
            if fails:
                raise RuntimeError
    except RuntimeError:
        pass
    assert termios.tcgetattr(slave) == before


def test_what_was_typed_blindly_does_not_reach_the_shell(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave):
        os.write(master, b"rm -r *\n")
        select.select([slave], [], [], 5.0)
    assert not select.select([slave], [], [], 0.1)[0]


@pytest.mark.parametrize(
    ("sequence", "name"),
    [
        (b"\x1b[A", "Up"),
        (b"\x1bOD", "Left"),
        (b"\x1b[6~", "PageDown"),
        (b"\x1b[15~", "F5"),
        (b"\r", "Enter"),
        (b"A", "a"),
    ],
)
def test_special_keys_have_names(pty: tuple[int, int], sequence: bytes, name: str) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, sequence + b"q") == [name, "q"]


@pytest.mark.parametrize("sequence", [b"\x1b[1;5D", b"\x1ba", b"\x1b[200~", b"\x1b[M"])
def test_no_other_special_key_passes_for_a_letter(pty: tuple[int, int], sequence: bytes) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, sequence + b"q") == ["q"]


def test_a_sequence_that_comes_in_two_parts_is_no_letter_either(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"s\x1b[") == ["s"]
        keyboard._unfinished_at = time.monotonic()  # however long this test was held up
        assert pressed(keyboard, master, b"Aq") == ["Up", "q"]


def test_escape_alone_does_not_swallow_the_next_key(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"\x1b") == []
        time.sleep(0.15)
        assert pressed(keyboard, master, b"a") == ["a"]


def test_keys_that_would_freeze_the_screen_are_off(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"\x13\x1aq") == ["\x13", "\x1a", "q"]
        os.write(slave, b"seen")
        assert os.read(master, 10) == b"seen"


def test_bytes_that_are_no_text_are_no_keys(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        assert pressed(keyboard, master, b"\xff\xfea") == ["a"]


def test_a_terminal_that_is_gone_is_told(pty: tuple[int, int]) -> None:
    master, slave = pty
    with Keyboard(slave) as keyboard:
        os.close(master)
        with pytest.raises(HangUp):
            keyboard.read()

"""Keys of a console of Windows, by a stand-in for it."""

from collections import deque

import pytest
from virtual_time import VirtualTime

from mukca.drivers import clock
from mukca.recorder.terminal import ConsoleKeyboard


class Typed:
    """The module msvcrt, with keys that were typed."""

    def __init__(self, text):
        self._text = deque(text)

    def kbhit(self):
        return bool(self._text)

    def getwch(self):
        return self._text.popleft()


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("aQ 1", ["a", "q", "space", "1"]),
        ("\r\b\t\x1b", ["Enter", "Backspace", "Tab"]),
        ("\xe0H\xe0P\xe0K\xe0M", ["Up", "Down", "Left", "Right"]),
        (
            "\xe0G\xe0O\xe0I\xe0Q\xe0R\xe0S",
            ["Home", "End", "PageUp", "PageDown", "Insert", "Delete"],
        ),
        ("\0;\0D\xe0\x85", ["F1", "F10", "F11"]),
        ("\0\x01\xe0q", []),  # no other special key passes for a letter
        ("ж€", []),
    ],
)
def test_keys_of_a_console_are_those_of_a_terminal(text, names):
    with VirtualTime().running(), ConsoleKeyboard(Typed(text)) as keyboard:
        keys = []
        while clock.wait([keyboard], 1.0):
            keys += keyboard.read()
    assert keys == names

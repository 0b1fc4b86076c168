"""Keys of a console of Windows, by a stand-in for it."""

from collections import deque

from cases import by_table
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


@by_table("text", "names")
def test_keys_of_a_console_are_those_of_a_terminal(text, names):
    with VirtualTime().running(), ConsoleKeyboard(Typed(text)) as keyboard:
        keys = []
        while clock.wait([keyboard], 1.0):
            keys += keyboard.read()
    assert keys == names

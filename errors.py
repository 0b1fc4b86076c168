"""The base of all errors that a user can mend."""

import re


class MukcaError(Exception):
    """Base of all errors that a user can mend; the message is one line.

    The line says what is wrong, where (file, line, joint), and what would work.

    Attributes:
        failed: The input was good, and the work ran, but its result is not to be used.
    """

    failed: bool = False

    def __str__(self) -> str:
        return shortened(super().__str__())


LONGEST_WORD, LONGEST_LINE = 400, 4000
"""Characters of what a message quotes, and of a whole message."""


def shortened(text: str) -> str:
    """Return a message whose long words have lost their middles, and the whole if it is long."""
    text = re.sub(rf"\S{{{LONGEST_WORD},}}", lambda word: _ends(word[0], LONGEST_WORD), text)
    return _ends(text, LONGEST_LINE)


def _ends(text: str, most: int) -> str:
    """Return a text's beginning and end, which are at most so many characters."""
    half = most // 2 - 3
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"

"""Letters three rows high, to be read from two metres away."""

from rich.text import Text

_LETTERS: dict[str, tuple[str, ...]] = {
    letter: tuple(rows)
    for letters, *lines in (
        (
            "0123456789",
            "█▀█|▀█ |▀▀█|▀▀█|█ █|█▀▀|█▀▀|▀▀█|█▀█|█▀█",
            "█ █| █ |█▀▀| ▀█|▀▀█|▀▀█|█▀█|  █|█▀█|▀▀█",
            "▀▀▀|▀▀▀|▀▀▀|▀▀▀|  ▀|▀▀▀|▀▀▀|  ▀|▀▀▀|▀▀▀",
        ),
        (
            "ABCDEFGHIJKLM",
            "▄▀▄|█▀▄|█▀▀|█▀▄|█▀▀|█▀▀|█▀▀▀|█ █|█|  █|█ █|█  |█▄ ▄█",
            "█▀█|█▀▄|█  |█ █|█▀ |█▀ |█ ▀█|█▀█|█|  █|█▀▄|█  |█ ▀ █",
            "▀ ▀|▀▀ |▀▀▀|▀▀ |▀▀▀|▀  |▀▀▀▀|▀ ▀|▀|▀▀▀|▀ ▀|▀▀▀|▀   ▀",
        ),
        (
            "NOPQRSTUVWXYZ? ",
            "█▄ █|█▀▀█|█▀█|█▀▀█|█▀█|█▀▀|▀█▀|█ █|█ █|█ █ █|█ █|█ █|▀▀█|▀▀█| ",
            "█ ▀█|█  █|█▀▀|█ ▄█|█▀▄|▀▀█| █ |█ █|█ █|█ █ █|▄▀▄| █ |▄▀ | ▀ | ",
            "▀  ▀|▀▀▀▀|▀  |▀▀▀▀|▀ ▀|▀▀▀| ▀ |▀▀▀| ▀ | ▀ ▀ |▀ ▀| ▀ |▀▀▀| ▀ | ",
        ),
    )
    for letter, *rows in zip(letters, *(line.split("|") for line in lines), strict=True)
}
"""Three rows a letter, five half-rows high."""


def banner(words: str, colour: str, width: int) -> list[Text]:
    """Return some words as three lines, each as wide as the screen and all of one colour."""
    rows = [" " + " ".join(_LETTERS.get(c, _LETTERS["?"])[row] for c in words) for row in range(3)]
    return [Text(row[:width].ljust(width), style=f"bold white on {colour}") for row in rows]

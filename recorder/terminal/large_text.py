"""Letters three rows high, to be read from two metres away."""

from rich.text import Text

# Three rows a letter, five half-rows high.
_LETTERS: dict[str, tuple[str, str, str]] = {
    "0": ("█▀█", "█ █", "▀▀▀"),
    "1": ("▀█ ", " █ ", "▀▀▀"),
    "2": ("▀▀█", "█▀▀", "▀▀▀"),
    "3": ("▀▀█", " ▀█", "▀▀▀"),
    "4": ("█ █", "▀▀█", "  ▀"),
    "5": ("█▀▀", "▀▀█", "▀▀▀"),
    "6": ("█▀▀", "█▀█", "▀▀▀"),
    "7": ("▀▀█", "  █", "  ▀"),
    "8": ("█▀█", "█▀█", "▀▀▀"),
    "9": ("█▀█", "▀▀█", "▀▀▀"),
    "A": ("▄▀▄", "█▀█", "▀ ▀"),
    "B": ("█▀▄", "█▀▄", "▀▀ "),
    "C": ("█▀▀", "█  ", "▀▀▀"),
    "D": ("█▀▄", "█ █", "▀▀ "),
    "E": ("█▀▀", "█▀ ", "▀▀▀"),
    "F": ("█▀▀", "█▀ ", "▀  "),
    "G": ("█▀▀▀", "█ ▀█", "▀▀▀▀"),
    "H": ("█ █", "█▀█", "▀ ▀"),
    "I": ("█", "█", "▀"),
    "J": ("  █", "  █", "▀▀▀"),
    "K": ("█ █", "█▀▄", "▀ ▀"),
    "L": ("█  ", "█  ", "▀▀▀"),
    "M": ("█▄ ▄█", "█ ▀ █", "▀   ▀"),
    "N": ("█▄ █", "█ ▀█", "▀  ▀"),
    "O": ("█▀▀█", "█  █", "▀▀▀▀"),
    "P": ("█▀█", "█▀▀", "▀  "),
    "Q": ("█▀▀█", "█ ▄█", "▀▀▀▀"),
    "R": ("█▀█", "█▀▄", "▀ ▀"),
    "S": ("█▀▀", "▀▀█", "▀▀▀"),
    "T": ("▀█▀", " █ ", " ▀ "),
    "U": ("█ █", "█ █", "▀▀▀"),
    "V": ("█ █", "█ █", " ▀ "),
    "W": ("█ █ █", "█ █ █", " ▀ ▀ "),
    "X": ("█ █", "▄▀▄", "▀ ▀"),
    "Y": ("█ █", " █ ", " ▀ "),
    "Z": ("▀▀█", "▄▀ ", "▀▀▀"),
    "?": ("▀▀█", " ▀ ", " ▀ "),
    " ": (" ", " ", " "),
}


def banner(words: str, colour: str, width: int) -> list[Text]:
    """Return some words as three lines, each as wide as the screen and all of one colour.

    Args:
        words: Of capital letters, digits, blanks and question marks.
        colour: Of the background, as rich names it.
        width: Columns of the screen.
    """
    rows = [" " + " ".join(_LETTERS.get(c, _LETTERS["?"])[row] for c in words) for row in range(3)]
    return [Text(row[:width].ljust(width), style=f"bold white on {colour}") for row in rows]

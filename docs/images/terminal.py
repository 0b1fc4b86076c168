"""Draws docs/images/terminal.svg: a session in a terminal, frame by frame, as it was shown.

    python docs/images/terminal.py [DEMO]

Needs the test extra. Takes what `mukca demo --out DEMO` wrote, or runs it first. Runs the real
commands, reads what they draw with a terminal emulator, and writes the frames one over the other,
each shown for its time. The first is a guided session, led by the simulated hand that follows it.
"""

import os
import re
import shlex
import shutil
import sys
import tempfile
import time
from contextlib import suppress
from html import escape
from pathlib import Path

import pexpect
import pyte

COLUMNS, ROWS = 100, 34
FRAME = 0.15
"""How long a line is the last one shown [s]."""
WIDE, HIGH = 8.4, 17.0
COLOURS = {
    "default": "#d7dde4", "red": "#ff7b72", "green": "#7ee787", "brown": "#e3b341",
    "blue": "#79c0ff", "magenta": "#d2a8ff", "cyan": "#76e3ea", "black": "#8b949e",
    "white": "#ffffff",
}  # fmt: skip
KEYS = {
    "PRESS": " ",
    "SOCKET 0 NOW": "s",
    "SOCKET 1 NOW": "s",
    "ENOUGH": "q",
    "NEXT PLACE": "q",
}
"""Keys that a session asks for."""
BETWEEN = ("PRESS", "MOVE", "HOLD", "NEXT POSE", *(f"GOT {i}" for i in range(100)))
WHOLE = 3
"""Samples of which each step is shown; of the others, the changes of sockets alone."""
LOOK = 0.2
"""Time between two looks at the screen [s]."""
MUKCA = str(Path(sys.executable).with_name("mukca"))


class Film:
    """Frames of a terminal: its rows of coloured text, and how long each is shown."""

    def __init__(self) -> None:
        self.screen = pyte.Screen(COLUMNS, ROWS)
        self.stream = pyte.ByteStream(self.screen)
        self.frames: list[tuple[str, float]] = []

    def take(self, seconds: float) -> None:
        """Keep what is shown now, for so long."""
        rows = "".join(self.row(y) for y in range(ROWS))
        if self.frames and self.frames[-1][0] == rows:
            self.frames[-1] = (rows, self.frames[-1][1] + seconds)
        else:
            self.frames.append((rows, seconds))

    def row(self, y: int) -> str:
        """Return a row of the screen as SVG."""
        spans, cells = "", self.screen.buffer[y]
        x = 0
        while x < COLUMNS:
            cell, begin, text = cells[x], x, ""
            style = (cell.fg, cell.bold, cell.reverse)
            while (
                x < COLUMNS and (cells[x].fg, cells[x].bold, cells[x].reverse) == style
            ):
                text += cells[x].data or " "
                x += 1
            if text.strip():
                colour = COLOURS.get(cell.fg, f"#{cell.fg}")
                weight = ' font-weight="bold"' if cell.bold else ""
                spans += (
                    f'<tspan x="{begin * WIDE:.1f}" fill="{colour}"{weight}>'
                    f"{escape(text.rstrip())}</tspan>"
                )
        return f'<text y="{(y + 1) * HIGH:.0f}">{spans}</text>' if spans else ""

    def type(self, text: str) -> None:
        """Show how a command is typed."""
        self.stream.feed(b"\x1b[32m$\x1b[0m ")
        for end in range(0, len(text), 6):
            self.stream.feed(text[end : end + 6].encode())
            self.take(0.12)
        self.stream.feed(b"\r\n")
        self.take(0.3)

    def svg(self) -> str:
        """Return all frames as one picture that plays for ever."""
        whole = sum(seconds for _, seconds in self.frames)
        style, groups, at = "", "", 0.0
        for i, (rows, seconds) in enumerate(self.frames):
            a, b = 100 * at / whole, 100 * (at + seconds) / whole
            before = (
                f"0%{{opacity:0}}{max(a - 0.001, 0):.3f}%{{opacity:0}}" if i else ""
            )
            after = f"{b + 0.001:.3f}%{{opacity:0}}100%{{opacity:0}}"
            after = after if i < len(self.frames) - 1 else "100%{opacity:1}"
            style += (
                f"@keyframes f{i}{{{before}{a:.3f}%{{opacity:1}}{b:.3f}%{{opacity:1}}{after}}}"
                f".f{i}{{opacity:0;animation:f{i} {whole:.1f}s step-end infinite}}"
            )
            groups += f'<g class="f{i}">{rows}</g>'
            at += seconds
        wide, high = COLUMNS * WIDE + 24, ROWS * HIGH + 24
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide:.0f} {high:.0f}" '
            f'role="img"><title>A guided session, recordings checked, and a calibration</title>'
            f"<style>text{{font:14px monospace;white-space:pre}}{style}</style>"
            f'<rect width="100%" height="100%" rx="8" fill="#0d1117"/>'
            f'<g transform="translate(12 8)">{groups}</g></svg>\n'
        )


def run(film: Film, words: list[str], folder: Path) -> None:
    """Type a command, run it, and keep what it draws."""
    film.type(shlex.join(["mukca", *words]))
    child = pexpect.spawn(
        MUKCA,
        words,
        cwd=folder,
        dimensions=(ROWS, COLUMNS),
        env={**os.environ, "TERM": "xterm"},
    )
    child.timeout = 600
    for line in child:
        film.stream.feed(line)
        film.take(FRAME)
    child.close()
    film.take(4.0)


def lead(film: Film, words: list[str], folder: Path) -> None:
    """Type the command of a guided session, press what it asks for, and keep its moments."""
    film.type(shlex.join(["mukca", *words]))
    child = pexpect.spawn(
        MUKCA,
        words,
        cwd=folder,
        dimensions=(ROWS, COLUMNS),
        env={**os.environ, "TERM": "xterm"},
    )
    shown, asked = "", ""
    while child.isalive() and asked not in ("ENOUGH", "NEXT PLACE"):
        until = time.monotonic() + LOOK
        while time.monotonic() < until:
            with suppress(pexpect.TIMEOUT):
                film.stream.feed(child.read_nonblocking(65536, timeout=LOOK / 4))
        rows = "\n".join(film.screen.display)
        status = re.search(r"^ SOCKET \d  ([A-Z][A-Z0-9 ]+)\b", rows, re.MULTILINE)
        asked = status[1].strip() if status else ""
        if asked == shown:
            continue
        if rows.count(" sample ") < WHOLE or asked not in BETWEEN:
            film.take(4.0 if asked == "ENOUGH" else 1.0)
        shown = asked
        child.send(KEYS.get(asked, ""))
    child.expect(pexpect.EOF, timeout=600)
    film.screen.reset()


def main() -> None:
    film = Film()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if len(sys.argv) > 1:
            shutil.copytree(sys.argv[1], folder / "demo")
        else:
            pexpect.run(f"{MUKCA} demo --out demo", cwd=name, timeout=600)
        where = "--robot panda --distance 0.1"
        driver = "mock:demo/hand/front?follow&rate=100"
        lead(
            film,
            ["record", *where.split(), "--driver", driver, "--out", "led/front"],
            folder,
        )
        for command in (
            f"check demo/recordings {where}",
            f"solve demo/recordings {where} --out calibrated",
        ):
            run(film, command.split(), folder)
    Path(__file__).with_name("terminal.svg").write_text(film.svg())


if __name__ == "__main__":
    main()

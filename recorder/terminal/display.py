"""Display of views on a terminal: only changed lines are written, so SSH has little to carry."""

import os
import shutil
import subprocess
import sys
from contextlib import suppress

from rich.console import Console, ConsoleDimensions, Group
from rich.text import Text

from ...drivers import clock
from ...errors import MukcaError
from ..session import View
from .keyboard import HangUp
from .screen import BAR, advice_lines, help_lines, render

_ENTER = "\x1b[?1049h\x1b[?25l\x1b[2J"
_LEAVE = "\x18\x1b[?25h\x1b[?1049l"
"""Its first character ends a sequence of which only a part was written."""

LAST_TRIES, PAUSE = 30, 0.05
"""So often, after such pauses, a slow line is asked to leave the screen before all wait [s]."""


class Screen:
    """A full terminal screen; what was on it before is restored at the end.

    It waits for no slow line: a frame is drawn once the one before is written.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._descriptor = console.file.fileno()
        self._plain = not console.encoding.lower().startswith("utf")
        self._lines: list[Text] = []
        self._size = ConsoleDimensions(0, 0)
        self._output = -1
        self._unwritten = b""

    def __enter__(self) -> "Screen":
        # The shell shares the terminal's own descriptor, and expects its writes to wait.
        if sys.platform != "win32":
            flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY
            with suppress(OSError):
                self._output = os.open(os.ttyname(self._descriptor), flags)
        if self._output < 0:
            self._output = os.dup(self._descriptor)
        self._write(_ENTER)
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(HangUp):
            for _try in range(LAST_TRIES):
                self._drop()
                self._write(_LEAVE)
                if not self._unwritten:
                    break
                clock.sleep(PAUSE)
            if self._unwritten and sys.platform != "win32":
                os.set_blocking(self._output, True)
                self._write("")
        os.close(self._output)

    def _drop(self) -> None:
        """Drop what a slow line has not carried: the screen is gone with the session."""
        if self._unwritten and sys.platform != "win32":
            import termios

            self._unwritten = b""
            with suppress(termios.error):
                termios.tcflush(self._output, termios.TCOFLUSH)

    def restore(self) -> None:
        """Draw all lines again, since a shell had the terminal meanwhile."""
        self._write(_ENTER)
        self._size = ConsoleDimensions(0, 0)

    def show(self, view: View) -> None:
        """Draw a view, unless the terminal has yet to take in the last one."""
        self._write("")
        if self._unwritten:
            return
        # The terminal itself knows: what the shell exported in COLUMNS may be out of date.
        try:
            columns, rows = os.get_terminal_size(self._descriptor)
        except OSError:
            raise HangUp from None
        # A serial line does not know its size.
        width, height = size = ConsoleDimensions(columns or 80, rows or 24)
        text = ""
        if size != self._size:
            self._size = self._console.size = size
            self._lines = []
            text = "\x1b[2J"
        lines = render(view, width, height, ascii_only=self._plain)
        shown = [*map(_content, self._lines), *[None] * height]
        contents = enumerate(map(_content, lines))
        changed = [row for row, content in contents if content != shown[row]]
        with self._console.capture() as capture:
            self._console.print(Group(*(lines[row] for row in changed)))
        for row, line in zip(changed, capture.get().split("\n"), strict=False):
            text += f"\x1b[{row + 1};1H{line}\x1b[K"
        self._lines = lines
        self._write(text)

    def bell(self) -> None:
        """Ring the terminal's bell, once for all that a slow line has not carried yet."""
        if not self._unwritten.endswith(b"\a"):
            self._write("\a")

    def _write(self, text: str) -> None:
        """Write what the terminal takes in now, and keep what it does not."""
        self._unwritten += text.encode(self._console.encoding, errors="replace")
        try:
            while self._unwritten:
                count = os.write(self._output, self._unwritten)
                self._unwritten = self._unwritten[count:]
        except BlockingIOError:
            return
        except OSError:
            raise HangUp from None


def _content(line: Text) -> object:
    return line.plain, line.style, line.spans


class Lines:
    """Messages as lines of text, for a pipe, a file or a simple terminal; if brief, alarms only."""

    def __init__(self, console: Console, *, brief: bool = False) -> None:
        self._console = console
        self._brief = brief
        self._last: object = None
        self._words = ""
        self._advice: list[str] = []
        self._news: object = None
        self._helped = False

    def __enter__(self) -> "Lines":
        return self

    def __exit__(self, *_: object) -> None:
        return

    def restore(self) -> None:
        """Do nothing: lines that were printed stay."""

    def show(self, view: View) -> None:
        """Print what is new: messages, advice, the prompt, the help when it is asked for."""
        messages = view.session.messages
        number = next((i for i, m in enumerate(messages, 1) if m is self._last), 0)
        try:
            for message in messages[number:]:
                if self._brief and not message.alarm:
                    continue
                self._console.print(
                    ("! " if message.alarm else "") + message.text, markup=False
                )
            self._show_advice(view)
            if not view.scripted:
                self._show_prompt(view)
            if view.help and not self._helped:
                self._console.print("\n".join(help_lines(view)), markup=False)
        except OSError:
            raise HangUp from None
        self._last = messages[-1] if messages else None
        self._helped = view.help

    def _show_advice(self, view: View) -> None:
        """Print what is new in advice, and no turns again while the arm is on its way."""
        advice = view.advice
        news = advice and (advice.predicted, advice.target, advice.closing)
        if news == self._news:
            return
        self._news = news
        lines = advice_lines(view, 200)
        for line in lines:
            if line not in self._advice:
                self._console.print(line, markup=False)
        self._advice = lines or self._advice

    def _show_prompt(self, view: View) -> None:
        """Print the keys once, and the prompt whenever its words change.

        Of a typed line, and of the number of the next sample, each change is printed as well.
        """
        prompt = view.prompt
        in_full = prompt.words in ("WHICH?", "PRESS")
        words = prompt.text if in_full else prompt.words
        if words == self._words or view.captured:  # a message says that
            return
        if not self._words:
            self._console.print(view.session.with_keys(BAR), markup=False)
        self._words = words
        text = f"socket {view.session.socket}  {prompt.text}"
        self._console.print("\n".join([*view.resume_summary, text]), markup=False)

    def bell(self) -> None:
        """Ring the bell of a simple terminal; a pipe has none."""
        if self._console.is_terminal:
            with suppress(OSError):
                self._console.file.write("\a")
                self._console.file.flush()


PROGRAMS = ("spd-say", "espeak-ng", "espeak", "say")
"""Programs that say what they are given as their argument; the first that is there is taken."""

LAST_WORDS = 3.0
"""Longest wait for the last words [s]."""


class NoSpeechError(MukcaError):
    """No program that speaks is installed."""


class Speech:
    """A voice, which leaves off in the middle of a word where there is something newer to say.

    Raises:
        NoSpeechError: There is no program that speaks.
    """

    def __init__(self) -> None:
        found = next(filter(None, map(shutil.which, PROGRAMS)), None)
        if found is None:
            raise NoSpeechError(f"--say needs one of {', '.join(PROGRAMS)}; install it")
        self._program = found
        self._speaking: subprocess.Popen[bytes] | None = None

    def __call__(self, words: str) -> None:
        """Say some words, in place of those before."""
        if self._speaking and self._speaking.poll() is None:
            self._speaking.kill()
            self._speaking.wait()
        nowhere = subprocess.DEVNULL
        self._speaking = subprocess.Popen(  # noqa: S603, a program of the table above
            [self._program, words.lstrip("-")],
            stdin=nowhere,
            stdout=nowhere,
            stderr=nowhere,
            start_new_session=True,
        )

    def close(self) -> None:
        """Let the last words end, and take their program off the system's list."""
        if self._speaking:
            try:
                self._speaking.wait(timeout=LAST_WORDS)
            except subprocess.TimeoutExpired:
                self._speaking.kill()
                self._speaking.wait()

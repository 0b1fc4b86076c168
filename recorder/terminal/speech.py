"""The system's speech: it says words aloud, and is never waited for."""

import shutil
import subprocess

from ...errors import MukcaError

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

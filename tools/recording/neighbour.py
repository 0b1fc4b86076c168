"""A program beside the recorder that answers one line with one line, so that nothing waits."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Generator, Mapping
from contextlib import suppress
from typing import Any


class WorkerProcess:
    """A process of its own, which a recorder talks to without ever waiting.

    It gets a line only after it has answered the one before, so the pipe between them never fills.
    It ends by itself when the recorder does, however that comes.

    Args:
        module: What it runs, as in ``mukca.tools.recording.coaching``.
        setup: Its first line, which it does not answer.
    """

    def __init__(self, module: str, setup: Mapping[str, Any]) -> None:
        self.trouble: str | None = None
        """Why it does not answer any more; None while it does."""
        self._busy = False
        self._part = b""
        self._process = subprocess.Popen(  # noqa: S603 - our own module
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the recorder
        )
        assert self._process.stdin and self._process.stdout
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        self._write(setup)

    @property
    def idle(self) -> bool:
        """Whether a line can be sent."""
        return not self._busy and self.trouble is None

    def send(self, value: Mapping[str, Any]) -> None:
        """Send a line, if it is idle."""
        if self.idle:
            self._busy = True
            self._write(value)

    def answer(self) -> Any:
        """Return the answer that has come since; None without one."""
        if self.trouble is not None or not select.select([self._from], [], [], 0)[0]:
            return None
        data = os.read(self._from, 1 << 20)
        if not data:
            self.trouble = f"it ended with status {self._process.poll()}"
            return None
        *lines, self._part = (self._part + data).split(b"\n")
        if not lines:
            return None
        self._busy = False
        return json.loads(lines[-1])

    def close(self) -> None:
        """End it; safe to call twice."""
        self.trouble = self.trouble or "it is closed"
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                if pipe:
                    pipe.close()
        self._process.kill()  # it holds nothing that could be lost
        self._process.wait()

    def _write(self, value: Mapping[str, Any]) -> None:
        data = json.dumps(value).encode() + b"\n"
        try:
            while data:
                data = data[os.write(self._to, data) :]
        except OSError as error:
            self.trouble = f"it cannot be reached: {error.strerror}"


def lines_from_recorder() -> Generator[Any, None, None]:
    """Yield the lines that a recorder sends, in the process beside it."""
    for line in sys.stdin.buffer:
        yield json.loads(line)

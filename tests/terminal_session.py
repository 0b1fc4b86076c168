"""A program in a real pseudo-terminal, and the text on its screen."""

import contextlib
import fcntl
import os
import signal
import struct
import subprocess
import sys
import termios
import threading
import time

import pyte

MUKCA = [sys.executable, "-m", "mukca"]
PATIENCE = 200.0
"""A program on a busy computer may take so long for what it does in a moment [s].

It is less than the time limit of a test, so that a test says what it waited for.
"""


def _without_size():
    """The environment without the terminal's size, which a worker of tests has, too."""
    return {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}


class TerminalSession:
    """Runs a command with a pseudo-terminal as its standard streams and controlling terminal.

    Use it as a context manager; at its end the command is killed if it still runs.
    """

    def __init__(self, command, *, columns=80, rows=24, environment=None, limit_file_size=None):
        self.master, slave = os.openpty()
        self.slave = slave  # kept open, so that its settings can be read after the command's end
        self._set_size(columns, rows)
        self.before = termios.tcgetattr(slave)
        self.screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self.screen)
        self._lock = threading.Lock()
        self.output = b""

        if limit_file_size is not None:  # else compiled modules would be cut off
            environment = {**(environment or {}), "PYTHONDONTWRITEBYTECODE": "1"}

        def prepare():
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)
            if limit_file_size is not None:
                import resource

                resource.setrlimit(resource.RLIMIT_FSIZE, (limit_file_size, limit_file_size))

        self.process = subprocess.Popen(
            list(command),
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=prepare,
            env={**_without_size(), "TERM": "xterm-256color", **(environment or {})},
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.hang_up()
        self._reader.join(timeout=10)
        with contextlib.suppress(OSError):
            os.close(self.slave)

    @property
    def text(self):
        """What the screen shows."""
        columns = range(self.screen.columns)
        with self._lock:
            rows = [self.screen.buffer[y] for y in range(self.screen.lines)]
            return "\n".join("".join([row[x].data for x in columns]).rstrip() for row in rows)

    @property
    def settings(self):
        """The terminal's settings now."""
        return termios.tcgetattr(self.slave)

    def press(self, keys):
        """Type."""
        os.write(self.master, keys if isinstance(keys, bytes) else keys.encode())

    def wait_for(self, *texts, gone=(), timeout=PATIENCE):
        """Wait until the screen shows all of some texts and none of others; return the screen."""
        shows = lambda shown: self._shows(shown, texts) and not any(t in shown for t in gone)  # noqa: E731
        return self._wait_until(shows, f"{texts} without {gone}", timeout)

    def wait_for_either(self, *groups):
        """Wait until the screen shows all texts of a group; return the first such group."""
        first = lambda shown: [group for group in groups if self._shows(shown, group)]  # noqa: E731
        return first(self._wait_until(first, f"either of {groups}", PATIENCE))[0]

    def _shows(self, shown, texts):
        flat = "".join(line.ljust(self.screen.columns) for line in shown.split("\n"))
        return all(text in shown or text in flat for text in texts)  # flat: a long line unbroken

    def _wait_until(self, holds, wanted, timeout):
        """Look at the screen whenever something was written; it takes a while to put together."""
        deadline, seen, shown = time.monotonic() + timeout, -1, ""
        while time.monotonic() < deadline:
            if (written := len(self.output)) != seen:
                seen, shown = written, self.text
                if holds(shown):
                    return shown
            elif self.process.poll() is not None and not self._reader.is_alive():
                break
            time.sleep(0.02)
        raise AssertionError(f"{wanted} is not on the screen:\n{self.text}")

    def resize(self, columns, rows):
        """Change the terminal's size, as dragging its window does."""
        with self._lock:
            self.screen.resize(rows, columns)
        self._set_size(columns, rows)
        os.killpg(self.process.pid, signal.SIGWINCH)

    def hang_up(self):
        """Close the terminal, as a lost SSH connection does."""
        with contextlib.suppress(OSError):
            os.close(self.slave)
        with contextlib.suppress(OSError):
            os.close(self.master)

    def wait(self, timeout=PATIENCE):
        """Return the command's exit status."""
        return self.process.wait(timeout)

    def _set_size(self, columns, rows):
        size = struct.pack("HHHH", rows, columns, 0, 0)
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, size)

    def _read(self):
        while True:
            try:
                data = os.read(self.master, 65536)
            except OSError:
                return
            if not data:
                return
            with self._lock:
                self.output += data
                self._stream.feed(data)

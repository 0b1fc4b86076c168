"""Tells the operator when the stream of joint states fails, and when it is back."""

import math
import re

from ...drivers import clock
from ..stream import SILENT, Stream, StreamMonitor
from .actions import SessionActions


class StreamAlerts:
    """Follows a stream and its watch.

    Args:
        stream: The states.
        watch: What is thought of them.
        desk: Where news are told.
    """

    def __init__(self, stream: Stream, watch: StreamMonitor, desk: SessionActions) -> None:
        self._stream, self._watch, self._desk = stream, watch, desk
        self._started = clock.now()
        self._silent_since: float | None = None
        self._told = ""

    def trouble(self, now: float) -> str | None:
        """Say why the stream cannot be trusted now; None if it can."""
        if self._stream.trouble and self._watch.age(now) > SILENT:
            return f"the stream is silent: {self._stream.trouble}"
        return self._watch.unsound(now)

    def follow(self, now: float) -> None:
        """Tell what has changed."""
        silent = now - max(self._stream.arrival, self._started) > SILENT
        trouble = self.trouble(now)
        if not silent and self._silent_since is not None:
            self._desk.tell(f"the stream is back after {now - self._silent_since:.1f} s")
            self._silent_since, self._told = None, ""
        elif silent and self._silent_since is None:
            self._silent_since = now
            self._alarm(trouble or "the stream is silent")
        elif trouble is None:
            self._told = ""
        elif silent or math.isfinite(self._watch.age(now)):
            self._alarm(trouble)

    def _alarm(self, trouble: str) -> None:
        """Say what is wrong, once for each kind of trouble."""
        kind = re.sub(r"[\d.]+", "", trouble)
        if kind != self._told:
            self._told = kind
            self._desk.alarm(trouble)

"""Alerts to the operator when the stream of joint states fails, and when it is back."""

import math
import re

from ...drivers import clock
from ..stream import SILENT, Stream, StreamMonitor
from .actions import SessionActions


class StreamAlerts:
    """Alerts on a stream, one for each kind of trouble."""

    def __init__(self, stream: Stream, monitor: StreamMonitor, actions: SessionActions) -> None:
        self._stream, self._monitor, self._actions = stream, monitor, actions
        self._started = clock.now()
        self._silent_since: float | None = None
        self._alarmed = ""
        self._log_alarmed = False

    def trouble(self, now: float) -> str | None:
        """Return the reason why the stream cannot be trusted now; None if it can."""
        if self._stream.trouble and self._monitor.age(now) > SILENT:
            return f"the stream is silent: {self._stream.trouble}"
        return self._monitor.unsound(now)

    def update(self, now: float) -> None:
        """Alert to changes."""
        if self._stream.log and self._stream.log.trouble and not self._log_alarmed:
            self._log_alarmed = True
            self._actions.alarm(self._stream.log.trouble)
        silent = now - max(self._stream.arrival, self._started) > SILENT
        trouble = self.trouble(now)
        if not silent and self._silent_since is not None:
            self._actions.notify(f"the stream is back after {now - self._silent_since:.1f} s")
            self._silent_since, self._alarmed = None, ""
        elif silent and self._silent_since is None:
            self._silent_since = now
            self._alarm(trouble or "the stream is silent")
        elif trouble is None:
            self._alarmed = ""
        elif silent or math.isfinite(self._monitor.age(now)):
            self._alarm(trouble)

    def _alarm(self, trouble: str) -> None:
        """Tell trouble, once for each kind."""
        kind = re.sub(r"[\d.]+", "", trouble)
        if kind != self._alarmed:
            self._alarmed = kind
            self._actions.alarm(trouble)

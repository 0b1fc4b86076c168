"""A clock on which minutes pass in milliseconds: it goes on when everybody waits.

All runs in one thread, so that a test goes the same way every time, however busy the computer is:
whoever waits hands over to those whose turn it is, and the clock jumps to the next moment at which
something happens. Sockets and lines are real; their bytes are there as soon as they were sent, but
for a moment in which the kernel carries them (:data:`CARRIED`).
"""

import select
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

import pytest

from mukca.recorder.stream import Stream

CARRIED = 0.05
"""How long a byte may be under way in the kernel of a busy computer [s, real]."""

LATE = 1e-6
"""Nobody is woken earlier than asked, and by a real clock always somewhat later [s]."""


class Peer(Protocol):
    """Somebody who acts at moments of his own, or when there is something to read."""

    watched: dict[int, Callable[[], None]]

    def heed(self, readable: Sequence[int]) -> None: ...
    def due(self) -> float: ...
    def send_due(self) -> None: ...


class Every:
    """A peer that does the same again and again."""

    def __init__(self, time: "VirtualTime", seconds: float, act: Callable[[], object]) -> None:
        self.watched: dict[int, Callable[[], None]] = {}
        self._seconds, self._act = seconds, act
        self._next = time.now() + seconds

    def heed(self, readable: Sequence[int]) -> None:
        pass

    def due(self) -> float:
        return self._next

    def send_due(self) -> None:
        self._next += self._seconds
        self._act()


class VirtualTime:
    """Stands in for :mod:`mukca.drivers.clock`, and for the recorder's reading thread."""

    def __init__(self) -> None:
        self.peers: list[Peer] = []
        self._now = 1000.0
        self._streams: list[Stream] = []
        self._reading = False

    def now(self) -> float:
        return self._now

    def sleep(self, seconds: float) -> None:
        self.wait([], seconds)

    def wait(self, sources: Sequence[Any], seconds: float) -> list[Any]:
        end = self._now + seconds
        while True:
            ready = self._ready(sources, 0.0)
            if ready or self._now >= end:
                return ready
            if self._streams and not self._reading:
                self._read()
                continue
            peer = min(self.peers, key=lambda peer: peer.due(), default=None)
            if peer is not None and peer.due() <= end:
                self._now = max(self._now, peer.due())
                peer.send_due()
                continue
            if sources and any(peer.watched for peer in self.peers):
                if ready := self._ready(sources, CARRIED):
                    return ready
                if any(peer.due() <= end for peer in self.peers):  # somebody was asked to begin
                    continue
            self._now = end + LATE

    def _ready(self, sources: Sequence[Any], carried: float) -> list[Any]:
        """Let peers act on what has come in; return the sources that can be read then."""
        while True:
            watched = [file for peer in self.peers for file in peer.watched]
            readable = select.select([*sources, *watched], [], [], carried)[0]
            asked = [peer for peer in self.peers if any(f in readable for f in peer.watched)]
            if not asked:
                return [source for source in sources if source in readable]
            for peer in asked:
                peer.heed([file for file in readable if file in peer.watched])

    def _read(self) -> None:
        """Do what the threads of all streams do meanwhile."""
        self._reading = True
        for stream in list(self._streams):
            stream._step()
            if stream.ended:
                self._end(stream)
        self._reading = False

    def _end(self, stream: Stream) -> None:
        if stream in self._streams:
            self._streams.remove(stream)
            stream._driver.close()

    @contextmanager
    def running(self) -> Iterator["VirtualTime"]:
        """Put it in the place of the host's clock."""
        with pytest.MonkeyPatch.context() as patch:
            for name in ("now", "sleep", "wait"):
                patch.setattr(f"mukca.drivers.clock.{name}", getattr(self, name))
            patch.setattr(Stream, "_begin", lambda stream: self._streams.append(stream))
            patch.setattr(Stream, "close", lambda stream: self._end(stream))
            yield self

"""A clock on which minutes pass in milliseconds: it goes on when everybody waits.

All runs in one thread, so that a test goes the same way every time, however busy the computer is:
whoever waits hands over to those whose turn it is, and the clock jumps to the next moment at which
something happens. Sockets and lines are real; their bytes are there as soon as they were sent, but
for a moment in which the kernel carries them (:data:`CARRIED`).
"""

import select
from contextlib import contextmanager
from unittest.mock import patch

from mukca.drivers import clock

CARRIED = 0.05
"""How long a byte may be under way in the kernel of a busy computer [s, real]."""

LATE = 1e-6
"""Nobody is woken earlier than asked, and by a real clock always somewhat later [s]."""


class Every:
    """A peer, which acts at moments of its own or when it can read: the same again and again."""

    def __init__(self, time, seconds, act):
        self.watched = {}
        self._seconds, self._act = seconds, act
        self._next = time.now() + seconds

    def dispatch(self, readable):
        pass

    def due(self):
        return self._next

    def send_due(self):
        self._next += self._seconds
        self._act()


class VirtualTime:
    """Stands in for the host's clock, and for the threads that do something again and again."""

    def __init__(self):
        self.peers = []
        self._now = 1000.0
        self._threads = []
        self._stepping = False

    def now(self):
        return self._now

    def sleep(self, seconds):
        self.wait([], seconds)

    def wait(self, sources, seconds):
        end = self._now + seconds
        while True:
            ready = self._ready(sources, 0.0)
            if ready or self._now >= end:
                return ready
            if self._threads and not self._stepping:
                self._step()
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

    def _ready(self, sources, carried):
        """Let peers act on what has come in; return the sources that can be read then."""
        while True:
            watched = [file for peer in self.peers for file in peer.watched]
            readable = select.select([*sources, *watched], [], [], carried)[0]
            asked = [peer for peer in self.peers if any(f in readable for f in peer.watched)]
            if not asked:
                return [source for source in sources if source in readable]
            for peer in asked:
                peer.dispatch([file for file in readable if file in peer.watched])

    def repeat(self, step, end):
        thread = step, end
        self._threads.append(thread)
        return lambda: self._end(thread)

    def _step(self):
        """Do what all threads do meanwhile."""
        self._stepping = True
        for thread in list(self._threads):
            if not thread[0]():
                self._end(thread)
        self._stepping = False

    def _end(self, thread):
        if thread in self._threads:
            self._threads.remove(thread)
            thread[1]()

    def jump(self, moment):
        """Let it be another moment at once [s]; nobody acts meanwhile."""
        self._now = moment

    @contextmanager
    def running(self):
        """Put it in the place of the host's clock."""
        names = ("now", "sleep", "wait", "repeat")
        with patch.multiple(clock, **{name: getattr(self, name) for name in names}):
            yield self

"""A clock on which minutes pass in milliseconds: it goes on when everybody waits.

A test goes the same way every time, however busy the computer is. Sockets and lines are real; their
bytes are there as soon as they were sent, but for a moment in which the kernel carries them
(:data:`CARRIED`).
"""

import select

from mukca.tools.simulation import SimulatedTime

CARRIED = 0.05
"""How long a byte may be under way in the kernel of a busy computer [s, real]."""


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


class VirtualTime(SimulatedTime):
    """A simulated time in which peers act, too."""

    def __init__(self):
        super().__init__()
        self.peers = []
        self._sources = []

    def pass_until(self, end):
        peer = min(self.peers, key=lambda peer: peer.due(), default=None)
        if peer is not None and peer.due() <= end:
            self._now = max(self._now, peer.due())
            peer.send_due()
            return
        if self._sources and any(peer.watched for peer in self.peers):
            if self._carried(self._sources, CARRIED):
                return
            if any(peer.due() <= end for peer in self.peers):  # somebody was asked to begin
                return
        super().pass_until(end)

    def ready(self, sources):
        self._sources = sources
        return self._carried(sources, 0.0)

    def _carried(self, sources, carried):
        """Let peers act on what has come in; return the sources that can be read then."""
        while True:
            watched = [file for peer in self.peers for file in peer.watched]
            readable = select.select([*sources, *watched], [], [], carried)[0]
            asked = [peer for peer in self.peers if any(f in readable for f in peer.watched)]
            if not asked:
                return [source for source in sources if source in readable]
            for peer in asked:
                peer.dispatch([file for file in readable if file in peer.watched])

    def jump(self, moment):
        """Let it be another moment at once [s]; nobody acts meanwhile."""
        self._now = moment

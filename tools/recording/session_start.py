"""Start of a session: its keys, driver and files; anew, or as an earlier one left it."""

import time
from collections.abc import Generator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from ... import recorder
from ...drivers import Reconnecting, open_driver
from ...recorder.session import Message, Recording, Session
from ...solver.identification import robot as robots
from ..cli import Terminal
from ..simulation import FollowingHand, practice_driver
from .checks import similar_models
from .options import RecordOptions, joints_of

if TYPE_CHECKING:
    from .page import PageProcess

LOCAL_HOSTS = ("127.0.0.1", "localhost", "::1")
NOTES = ("operator", "serial_number", "warm_up", "temperature", "notes")


@contextmanager
def page_of(options: RecordOptions) -> "Generator[PageProcess | None, None, None]":
    """Serve the page, if it is asked for, for all placements of a run."""
    if not options.page:
        yield None
        return
    from .page import PageProcess

    with closing(PageProcess(options, options.page_host)) as page:
        yield page


@dataclass(frozen=True)
class SessionStart:
    """All that a session at one placement begins with."""

    options: RecordOptions
    metadata: recorder.Metadata
    robot: robots.Robot
    terminal: Terminal
    page: "PageProcess | None" = None
    """The page, which goes on at its address at the next placement."""
    hand: FollowingHand | None = None
    """The hand of a simulated arm, which leads on at the next placement."""
    recording: Recording | None = None
    """The placement, open, with the samples since the base moved; None at the first of a run."""

    def connect(self) -> Reconnecting:
        """Open the driver, or the hand's arm, as a driver that connects again by itself."""
        name, _, address = self.options.driver.partition(":")
        joint_names = self.robot.joint_names
        if self.hand:
            connection = self.hand.connection
        elif name == "mock" and "fault=" in address:
            connection = practice_driver(address, self.robot)
        else:
            connection = partial(open_driver, name, address, joint_names)
        return Reconnecting(connection, joint_names=joint_names)

    def open_recording(self, still: float) -> Recording:
        """Open the placement's files, with the notes on this session, if they are not yet."""
        if self.recording:
            return self.recording
        options = self.options
        notes = {name: getattr(options, name) for name in NOTES}
        session = {"driver": options.driver, "window": options.window, "still": still}
        session |= {name: value for name, value in notes.items() if value is not None}
        return Recording(options.out, replace(self.metadata, session=session))

    def first_session(self, recording: Recording, remark: str) -> Session:
        """Return the session as an earlier start left it, or as it moved here.

        Its messages tell what the driver remarked, and where the page is.
        """
        metadata = self.metadata
        content = recording.content
        session = Session(
            joints_of(self.robot),
            sockets=metadata.sockets,
            distance=metadata.distance,
            measured=metadata.measured,
            target=self.options.samples,
            socket=min(recording.socket, metadata.sockets - 1),
            samples=content.samples,
            withdrawn=content.withdrawn,
            similar_models=partial(similar_models, self.robot),
        )
        messages = [Message(text, alarm=True) for text in recording.remarks]
        messages += self._origin(session)
        messages += [Message(remark, alarm=True)] if remark else []
        messages += self._page_messages()
        return replace(session, messages=tuple(messages))

    def _origin(self, session: Session) -> list[Message]:
        """Return where the samples of a session come from: from before, or since the base moved."""
        moved = len(session.samples)
        if self.recording and moved:
            since = "the base moved"
            if self.metadata.readings_changed:
                since = "joints read otherwise, or another tool is on"
            words = f"with {moved} samples since {since}"
            return [Message(f"a new placement: {self.options.out}, {words}")]
        if session.samples:
            return [Message(f"continues a recording of {len(session.live)} samples")]
        return []

    def _page_messages(self) -> list[Message]:
        """Return where the page is, and a warning where others can see it."""
        if self.page is None:
            return []
        address = Message(f"page: {self.page.url}")
        if self.options.page_host in LOCAL_HOSTS:
            return [address]
        warning = "whoever knows this address can watch, from anywhere in the network"
        return [address, Message(warning, alarm=True)]

    def summary(self, recording: Recording, session: Session) -> tuple[str, ...]:
        """Return the recording that is continued, in lines; none at a new placement."""
        if self.recording or not recording.content.samples:
            return ()
        counts = ", ".join(
            f"{count} in socket {k}" for k, count in enumerate(session.counts)
        )
        last = session.samples[-1].time
        when = "at an unknown time"
        if last:
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(last))
        distance = self.metadata.distance
        distance_text = (
            "at an unknown distance"
            if distance is None
            else f"{1e3 * distance:g} mm apart"
        )
        return (
            f"Continues {counts}; the last {when}; in {recording.folder}",
            f"Sockets {distance_text}. The ball was last in socket {session.socket}.",
            "Is the base where it was?",
        )

"""Start of a session: its keys, driver and files; anew, or as an earlier one left it."""

import time
from collections.abc import Generator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from ...drivers import Reconnecting, open_driver
from ...recorder.session import Message, Recording, Session
from ...solver.identification import robot as robots
from ..cli import Terminal
from ..simulation import FollowingHand, practice_driver
from .options import RecordOptions, joints_of
from .wrong_readings import similar_models

if TYPE_CHECKING:
    from .page import PageProcess
import math
from collections.abc import Sequence
from pathlib import Path

from ...recorder import METADATA, Metadata, Placement, add_reading, read_keys
from ...solver.identification.data import AGREEING
from ..cli import DISTANCES

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
    metadata: Metadata
    robot: robots.Robot
    terminal: Terminal
    page: "PageProcess | None" = None
    """The page, which goes on at its address at the next placement."""
    hand: FollowingHand | None = None
    """The hand of a simulated arm, which leads on at the next placement."""
    lost: int = 0
    """Samples of this session that tell nothing of the placement, since joints read otherwise."""
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
        count = len(session.live)
        samples = f"{count} sample{'' if count == 1 else 's'}"
        if session.samples and self.recording:
            since = "the base moved"
            if metadata.readings_changed:
                since = "joints read otherwise, or another tool is on"
            words = f"with {samples} since {since}"
            messages.append(Message(f"a new placement: {self.options.out}, {words}"))
        elif session.samples:
            words = f"continues a recording of {samples}"
            messages.append(Message(words))
        if remark:
            messages.append(Message(remark, alarm=True))
        if self.page:
            messages.append(Message(f"page: {self.page.url}"))
        if self.page and self.options.page_host not in LOCAL_HOSTS:
            warning = (
                "whoever knows this address can watch, from anywhere in the network"
            )
            messages.append(Message(warning, alarm=True))
        return replace(session, messages=tuple(messages))

    def summary(self, recording: Recording, session: Session) -> tuple[str, ...]:
        """Return the recording that is continued, in lines; none at a new placement."""
        if self.recording or not session.samples:
            return ()
        counts = ", ".join(f"{n} in socket {k}" for k, n in enumerate(session.counts))
        last, when = session.samples[-1].time, "at an unknown time"
        if last:
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(last))
        distance, apart = self.metadata.distance, "at an unknown distance"
        if distance is not None:
            apart = f"{1e3 * distance:g} mm apart"
        return (
            f"Continues {counts}; the last {when}; in {recording.folder}",
            f"Sockets {apart}. The ball was last in socket {session.socket}.",
            "Is the base where it was?",
        )


def with_distance(metadata: Metadata, terminal: Terminal) -> Metadata:
    """Return metadata with the distance that the operator types."""
    question = "How far apart are the sockets' centres? In mm, by a caliper; the printed base has"
    distance = _typed_distance(f"{question} 100.", "not yet measured", terminal)
    if distance is None:
        return metadata
    return replace(metadata, distance=distance, measured=True)


def with_distance_of_base(
    metadata: Metadata, placements: Sequence[Placement], terminal: Terminal
) -> Metadata:
    """Return metadata with one distance for one base, where an earlier placement has another.

    The operator says whether it is the same base, which has the distance that was measured last.
    """
    measured = [p for p in placements if p.distance and not p.distance_assumed]
    if not measured or metadata.distance is None:
        return metadata
    last, before = measured[-1].name, measured[-1].distance or 0.0
    if abs(before - metadata.distance) <= AGREEING:
        return metadata
    question = (
        f"{last} says {1e3 * before:g} mm, this placement {1e3 * metadata.distance:g} mm. One base "
        "has one distance; of another base, type it again."
    )
    distance = _typed_distance(question, f"{1e3 * before:g}", terminal)
    return replace(metadata, distance=distance or before, measured=True)


def with_second_reading(
    metadata: Metadata, folder: Path, terminal: Terminal
) -> Metadata:
    """Return metadata with a second reading that the operator types, which the recording keeps."""
    if metadata.distance is None or len(read_keys(folder / METADATA).readings) > 1:
        return metadata
    question = "Measure the sockets' distance once more: solve believes two readings that agree."
    distance = _typed_distance(question, "no second reading", terminal)
    if distance is None:
        return metadata
    add_reading(folder, distance)
    return replace(metadata, distance=distance)


def _typed_distance(question: str, advice: str, terminal: Terminal) -> float | None:
    """Return a distance that the operator types [m]; None for an empty answer."""
    while True:
        terminal.say(question)
        try:
            answer = input(f"mm, or Enter for {advice}: ").replace("mm", "").strip()
        except EOFError:
            answer = ""
        if not answer:
            return None
        try:
            number = float(answer.replace(",", "."))
        except ValueError:
            number = math.nan
        metres = number if number < 1 else number / 1e3
        if DISTANCES[0] <= metres <= DISTANCES[1]:
            terminal.say(f"The sockets are {1e3 * metres:g} mm apart.")
            return metres
        terminal.say(f"{answer!r} is no distance in millimetres, for example 100.08")

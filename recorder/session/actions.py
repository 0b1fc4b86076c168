"""Actions on a session and its file, which is written first."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from .. import REDO, RELABEL, UNDO, Configuration, RecordingError, Sample
from ..stream import StationaryPose
from .recording_file import Recording
from .session import BLOCK, Session

CAPTURED, REFUSED, DONE = ".", "..", "..."
ALARM, ENOUGH, NEXT_PLACE = ".. .. ..", "... ...", "... ."
"""Patterns of tones: a dot is one, a blank a pause."""
APART = 0.25
"""Time from a tone, or a pause, to the next [s]; terminals merge tones that are closer."""
ALIKE = math.radians(25)
"""Poses within this of each other on every joint tell hardly any parameter [rad]."""
SAME_READING = 3e-4
"""Readings of a distance that differ by less are one [m]."""
Check = Callable[[Sequence[Sample]], str | None]
"""A test of the last of some poses by the model: its oddity in words, as in "puts the ball 80 mm
from the others"; None if nothing is odd."""


class Sound:
    """Bell that rings patterns unless it is off, and a voice if there is one, without waiting."""

    def __init__(
        self,
        ring: Callable[[], None],
        *,
        on: bool = True,
        say: Callable[[str], None] | None = None,
    ) -> None:
        self._ring = ring
        self._on = on
        self._say = say
        self._pattern = ""
        self._next = -math.inf

    def play(self, pattern: str, words: str = "") -> None:
        """Begin with a pattern, in place of what has not sounded yet, and say some words."""
        self._pattern = pattern if self._on else ""
        if self._say and words:
            self._say(words)

    def update(self, now: float) -> None:
        """Sound the next tone if it is due at this time [s, monotonic]."""
        if self._pattern and now >= self._next:
            if self._pattern[0] == ".":
                self._ring()
            self._pattern = self._pattern[1:]
            self._next = now + APART


@dataclass
class SessionActions:
    """A session with its file: a change is on the disk before :attr:`session` shows it."""

    session: Session
    recording: Recording
    sound: Sound
    plausible: Check | None = None
    refused: int = 0
    """Number of refused captures."""
    successor: Recording | None = None
    """The next placement, open, with the samples that moved there, once it is begun."""

    def notify(self, text: str) -> None:
        """Show a message to the operator."""
        self.session = self.session.with_message(text)

    def alarm(self, text: str, pattern: str = REFUSED) -> None:
        """Show a message that needs attention."""
        self.session = self.session.with_message(text, alarm=True)
        self.sound.play(pattern, self.session.messages[-1].text)

    def keep(self, text: str) -> None:
        """Go on although an alarm said this; the recording says so from now on."""
        if self._written("not noted", self.recording.keep_alarm, text):
            self.notify(f"kept as it is: {text}")

    def reconnected(self) -> None:
        """Remember that the stream was lost, and came back, before the next sample."""
        numbers = (*self.session.reconnected, self.session.next_number)
        self.session = replace(self.session, reconnected=numbers)

    def refuse(self, reason: str) -> None:
        """Show the reason why nothing is captured."""
        self.refused += 1
        self.alarm(f"refused: {reason}")

    def implausible(self, pose: StationaryPose) -> str | None:
        """Return the reason why a rest is not captured without a key; None if it is."""
        samples = (*self.session.live, self.session.sample_at(pose, time.time()))
        odd = self.plausible and self.plausible(samples)
        return f"this pose {odd}" if odd else None

    def capture(
        self, pose: StationaryPose, contact: str | None = None
    ) -> Sample | None:
        """Save a rest as a sample; None if that failed, and the operator was told."""
        sample = self.session.sample_at(pose, time.time())
        try:
            self.recording.capture(sample)
        except RecordingError as error:
            self.refuse(str(error))
            return None
        self.session = session = self.session.captured(sample)
        count = session.counts[sample.socket]
        done = count == session.target
        message = f"captured sample {sample.number}: {count} in socket {sample.socket}"
        if contact:
            message += f", while the arm was pushed ({contact})"
        if done:
            further = "{next} for the next socket, " if session.sockets > 1 else ""
            message += f"; that is the target: {further}{{finish}} to finish"
        self.notify(message)
        pattern = DONE if done or session.turn_done else CAPTURED
        self.sound.play(pattern, f"got {sample.number}")
        taken = len(session.live)
        if taken % BLOCK == 0 and session.span < ALIKE:
            self.alarm(
                f"all {taken} poses lie within 25 degrees of each other: lead every joint on"
            )
        if odd := self.plausible and self.plausible(session.live):
            back = "{undo} takes it back. Or has the base moved? {new}: new placement"
            self.alarm(f"sample {sample.number} {odd} {back}")
        return sample

    def undo(self) -> None:
        """Take the last sample back."""
        last = self.session.last
        if last is None:
            self.alarm("nothing to undo")
        else:
            self._take_back(last)

    def delete(self, number: int) -> None:
        """Take a sample back by its number."""
        sample = self._known(number)
        if not sample:
            return
        if number in self.session.withdrawn:
            self.alarm(
                f"sample {number} was taken back already; {{redo}} brings the last one again"
            )
        else:
            self._take_back(sample)

    def doubt(self, numbers: Sequence[int]) -> None:
        """Take samples back because of an alarm."""
        for number in numbers:
            self.delete(number)
        doubted = (*self.session.doubted, *numbers)
        self.session = replace(self.session, doubted=doubted)

    def avoid(self, pose: Configuration | None) -> None:
        """Propose a pose and its neighbours no more."""
        if pose is None:
            self.alarm("no pose is proposed now")
            return
        self.session = replace(self.session, avoided=(*self.session.avoided, pose))
        self.notify("that pose and its neighbours are proposed no more")

    def measured_again(self, distance: float) -> bool:
        """Write a further reading of the sockets' distance [m]; return whether it is as before."""
        before = self.recording.distance
        if not self._written("not done", self.recording.add_reading, distance):
            return False
        self.session = replace(self.session, distance=distance, measured=True)
        was = ""
        if before is not None:
            was = f", before {1e3 * before:g}; both readings are kept"
        self.notify(f"the sockets are {1e3 * distance:g} mm apart{was}")
        return before is not None and abs(distance - before) < SAME_READING

    def redo(self) -> None:
        """Bring the sample again that was taken back last."""
        if not self.session.withdrawn:
            self.alarm("nothing to bring again")
            return
        *withdrawn, number = self.session.withdrawn
        sample = self.session.samples[number - 1]
        if self._mark(REDO, sample):
            self.session = replace(self.session, withdrawn=tuple(withdrawn))
            self.notify(f"sample {number} of socket {sample.socket} counts again")

    def relabel(self, number: int, socket: int) -> None:
        """Give another socket to a sample."""
        sample = self._known(number)
        if not sample or not self._has(socket):
            return
        samples = list(self.session.samples)
        samples[number - 1] = replace(sample, socket=socket)
        if self._mark(RELABEL, samples[number - 1]):
            self.session = replace(self.session, samples=tuple(samples))
            self.notify(
                f"sample {number} is now of socket {socket}, before of {sample.socket}"
            )

    def begin_next(
        self, numbers: Sequence[int] = (), *, readings_changed: bool = False
    ) -> bool:
        """Begin the next placement, with the samples since the first of some; False if that failed.

        Of those that were taken back, the ones that an alarm took back and that are among them. The
        samples are on the disk there before they are taken back here.
        """
        session = self.session
        metadata = replace(
            self.recording.metadata,
            distance=session.distance,
            measured=session.measured,
            readings_changed=readings_changed,
        )
        doubts = set(numbers) & set(session.doubted) & set(session.withdrawn)
        if not self.has_samples_before(numbers):
            return False
        leaving = [s for s in session.live if numbers and s.number >= min(numbers)]
        part = [s for s in session.samples if s in leaving or s.number in doubts]
        try:
            successor = self.recording.begin_next(metadata, part)
        except RecordingError as error:
            self.alarm(f"not done: {error}")
            return False
        if leaving and not self._mark(UNDO, *leaving):
            successor.discard()
            return False
        self.successor = successor
        for sample in leaving:
            self.session = self.session.without(sample.number)
        return True

    def has_samples_before(self, numbers: Sequence[int] = ()) -> bool:
        """Return whether a sample would stay if those from the first of some on left; else say so.

        A folder without one may as well be the next placement's.
        """
        first = min(numbers, default=math.inf)
        stay = any(sample.number < first for sample in self.session.live)
        if not stay:
            self.alarm("no new placement: no sample would stay in this one; go on here")
        return stay

    def switch(self, socket: int) -> None:
        """Go on in another socket."""
        if not self._has(socket):
            return
        self.session = self.session.switched(socket)
        failed = f"socket {socket} is active, but"
        if self._written(failed, self.recording.set_socket, socket, mark=" "):
            self.notify(f"socket {socket} is active: put the ball there")

    def _known(self, number: int) -> Sample | None:
        count = len(self.session.samples)
        if 1 <= number <= count:
            return self.session.samples[number - 1]
        self.alarm(f"there is no sample {number}: they are 1 to {count}")
        return None

    def _has(self, socket: int) -> bool:
        count = self.session.sockets
        if socket >= count:
            self.alarm(f"there is no socket {socket}: they are 0 to {count - 1}")
        return socket < count

    def _take_back(self, sample: Sample) -> None:
        if self._mark(UNDO, sample):
            self.session = self.session.without(sample.number)
            self.notify(f"took back sample {sample.number} of socket {sample.socket}")

    def _mark(self, event: str, *samples: Sample) -> bool:
        return self._written(
            "not done", self.recording.mark, event, samples, time.time()
        )

    def _written(
        self,
        failed: str,
        write: Callable[..., object],
        *values: object,
        mark: str = ": ",
    ) -> bool:
        """Write to the recording; return False if that failed, and the operator was told."""
        try:
            write(*values)
        except RecordingError as error:
            self.alarm(f"{failed}{mark}{error}")
            return False
        return True

"""What a key does to a session and its file: the file first, then the session."""

import time
from collections.abc import Callable, Sequence

from .. import REDO, RELABEL, UNDO, RecordingError, Sample
from ..stream import StationaryPose
from .recording_file import Recording
from .session import Session
from .sound import CAPTURED, DONE, REFUSED, Sound


class SessionActions:
    """A session with the file it is written to.

    Whatever changes is on the disk before :attr:`session` shows it.

    Args:
        session: Where it begins.
        recording: Its file.
        sound: What the operator hears.
        check: Says what the last of some samples does that is odd by the model, as in "puts the
            ball 80 mm from the others"; None if nothing is.
        plausible: Likewise, of a pose that is to be captured without a key.
    """

    def __init__(
        self,
        session: Session,
        recording: Recording,
        sound: Sound,
        check: Callable[[Sequence[Sample]], str | None] | None = None,
        plausible: Callable[[Sequence[Sample]], str | None] | None = None,
    ) -> None:
        self.session = session
        self.refused = 0
        """How many captures were refused."""
        self.doubted = False
        """Whether the last sample was found odd."""
        self._recording = recording
        self._sound = sound
        self._check = check
        self._plausible = plausible

    def tell(self, text: str) -> None:
        """Say something to the operator."""
        self.session = self.session.with_message(text)

    def alarm(self, text: str) -> None:
        """Say something that needs attention."""
        self.session = self.session.with_message(text, alarm=True)
        self._sound.play(REFUSED)

    def refuse(self, reason: str) -> None:
        """Say why nothing is captured."""
        self.refused += 1
        self.alarm(f"refused: {reason}")

    def doubt(self, rest: StationaryPose) -> str | None:
        """Say why a rest is not captured without a key; None if it is."""
        odd = self._plausible and self._plausible((*self.session.live, self._sample(rest)))
        return f"this pose {odd}" if odd else None

    def capture(self, rest: StationaryPose, push: str | None = None) -> Sample | None:
        """Save a rest as a sample; None if that failed, which the operator was told.

        Args:
            rest: Where the arm is.
            push: What shows that it is being pushed.
        """
        sample = self._sample(rest)
        try:
            self._recording.capture(sample)
        except RecordingError as error:
            self.refuse(str(error))
            return None
        self.session = self.session.captured(sample)
        count = self.session.counts[sample.socket]
        said = f"captured sample {sample.number}: {count} in socket {sample.socket}"
        said += f", while the arm was pushed ({push})" if push else ""
        done = count == self.session.target
        further = "s for the next socket, " if self.session.sockets > 1 else ""
        said += f"; that is the target: {further}q to finish" if done else ""
        self.tell(said)
        self._sound.play(DONE if done else CAPTURED)
        odd = self._check and self._check(self.session.live)
        self.doubted = bool(odd)
        if odd:
            back = "u takes it back. Or has the base moved? n: new placement"
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
        if sample is None:
            return
        if number in self.session.withdrawn:
            self.alarm(f"sample {number} was taken back already; r brings the last one again")
        else:
            self._take_back(sample)

    def redo(self) -> None:
        """Bring the sample again that was taken back last."""
        if not self.session.withdrawn:
            self.alarm("nothing to bring again")
            return
        number = self.session.withdrawn[-1]
        sample = self.session.samples[number - 1]
        if self._mark(REDO, sample):
            self.session = self.session.restored(number)
            self.tell(f"sample {number} of socket {sample.socket} counts again")

    def relabel(self, number: int, socket: int) -> None:
        """Say in which socket a sample was taken."""
        sample = self._known(number)
        if sample is None or not self._has(socket):
            return
        moved = self.session.relabelled(number, socket)
        if self._mark(RELABEL, moved.samples[number - 1]):
            self.session = moved
            self.tell(f"sample {number} is now of socket {socket}, before of {sample.socket}")

    def switch(self, socket: int) -> None:
        """Go on in another socket."""
        if not self._has(socket):
            return
        self.session = self.session.switched(socket)
        try:
            self._recording.set_socket(socket)
        except RecordingError as error:
            self.alarm(f"socket {socket} is active, but {error}")
            return
        self.tell(f"socket {socket} is active: put the ball there")

    def _sample(self, rest: StationaryPose) -> Sample:
        return Sample(
            position=rest.position,
            socket=self.session.socket,
            effort=rest.effort,
            number=self.session.next_number,
            time=time.time(),
            stamp=rest.stamp,
            states=rest.states,
            spread=rest.spread,
        )

    def _known(self, number: int) -> Sample | None:
        sample = self.session.sample(number)
        if sample is None:
            self.alarm(f"there is no sample {number}: they are 1 to {len(self.session.samples)}")
        return sample

    def _has(self, socket: int) -> bool:
        if socket < self.session.sockets:
            return True
        self.alarm(f"there is no socket {socket}: they are 0 to {self.session.sockets - 1}")
        return False

    def _take_back(self, sample: Sample) -> None:
        if self._mark(UNDO, sample):
            self.session = self.session.without(sample.number)
            self.doubted = False
            self.tell(f"took back sample {sample.number} of socket {sample.socket}")

    def _mark(self, event: str, sample: Sample) -> bool:
        """Write a mark; False if that failed, which the operator was told."""
        try:
            self._recording.mark(event, sample, time.time())
        except RecordingError as error:
            self.alarm(f"not done: {error}")
            return False
        return True

"""Keeps asking an adviser as the session goes on, and keeps what it says."""

from .actions import SessionActions
from .guidance import Advice, GuidanceProvider, Question
from .sound import DONE, Sound


class GuidanceClient:
    """Asks whenever the samples or the socket have changed; never waits for an answer.

    Args:
        adviser: Is asked; None for nobody.
        desk: Whose session it is about.
        sound: Tells that a socket, or the placement, has enough.
    """

    def __init__(
        self, adviser: GuidanceProvider | None, desk: SessionActions, sound: Sound
    ) -> None:
        self.advice: Advice | None = None
        """The last that was given, and still holds."""
        self._adviser = adviser
        self._desk = desk
        self._sound = sound
        self._asked: object = None

    @property
    def here(self) -> Advice | None:
        """The advice, if it was given for the socket that is active."""
        advice = self.advice
        return advice if advice and advice.socket == self._desk.session.socket else None

    def go_on(self, position: tuple[float, ...] | None) -> None:
        """Take an answer that has come, and ask anew if there is reason to.

        Args:
            position: Where the arm is.
        """
        if self._adviser is None:
            return
        self._heed(self._adviser.answer())
        session = self._desk.session
        asked = (session.live, session.socket)
        if self._adviser.idle and asked != self._asked:
            self._asked = asked
            self._adviser.ask(Question(session.live, session.socket, position))
        if self._adviser.trouble:
            self._desk.tell(f"no advice any more: {self._adviser.trouble}; recording goes on")
            self._adviser = self.advice = None

    def _heed(self, advice: Advice | None) -> None:
        """Take advice over, unless the session has gone on since it was asked for."""
        session = self._desk.session
        if advice is None or (advice.count, advice.socket) != (len(session.live), session.socket):
            return
        before, self.advice = self.advice, advice
        if advice.doubt and not (before and before.doubt):
            self._desk.alarm(advice.doubt)
        done = advice.enough or advice.leave
        if done and not (before and (before.enough or before.leave)):
            self._sound.play(DONE)

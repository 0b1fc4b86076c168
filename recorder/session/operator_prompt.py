"""What the operator is to do now, in one or two words, and why, also before a key is refused.

===============  ================================================================================
words            meaning
===============  ================================================================================
GO ON?           a recording is continued: is it the right one?
WHICH?           a sample's number is being typed, so space would not capture
WAIT             the stream cannot be trusted now
SOCKET 1 NOW     this socket has enough, or the ball is to be moved over: put it into socket 1
ENOUGH           nothing more is needed at this placement
MOVE             the arm moves, or stands where no capture is taken: lead it to a new pose
NEXT POSE        it rests where a sample was taken already
HOLD             nearly still at a new pose
LET GO           a hand bends the arm; a capture is taken all the same
PRESS            a capture is taken now
GOT 17           a capture was taken a moment ago
===============  ================================================================================
"""

from collections.abc import Sequence
from dataclasses import dataclass

from .session import Session


@dataclass(frozen=True)
class OperatorContext:
    """What the operator's next step follows from."""

    session: Session
    position: Sequence[float] | None = None
    """Where the arm is, or rests; None before the first state."""
    trouble: str | None = None
    """Why the stream cannot be trusted; None if it can."""
    moving: str | None = None
    """Why the arm does not count as still; None if it is still."""
    fast: bool = False
    """Whether it moves so fast that it is being led on."""
    push: str | None = None
    """What shows that the arm is being pushed."""
    got: int | None = None
    """The number of a sample that was captured a moment ago."""
    leave: bool = False
    """Whether the active socket has enough samples, and another has not."""
    enough: str = ""
    """Why this placement needs no more; empty where it does."""
    doubt: str | None = None
    """Hands free: why this pose is not captured by itself."""
    hands_free: bool = False
    paused: bool = False
    """Whether a key is waited for before anything is captured."""
    prompt: str = ""
    """What is being typed; keys do not capture meanwhile."""
    asking: bool = False
    """Whether the operator is asked about what is continued."""
    capture_key: str = "space"


@dataclass(frozen=True)
class OperatorPrompt:
    """What to do now."""

    words: str
    colour: str
    reason: str

    @property
    def text(self) -> str:
        """Both in one line."""
        return f"{self.words}: {self.reason}" if self.reason else self.words


_CALM, _STEADY, _GOOD, _NEXT, _BAD = "blue", "dark_orange3", "dark_green", "magenta", "red"


def readiness(now: OperatorContext) -> OperatorPrompt:
    """Return what the operator is to do now."""
    return _before_all(now) or _by_place(now) or _by_motion(now)


def _before_all(now: OperatorContext) -> OperatorPrompt | None:
    """Return what holds wherever the arm is."""
    session = now.session
    key = now.capture_key
    if now.asking:
        return OperatorPrompt("GO ON?", _NEXT, "y: go on   n: new placement   q: leave")
    if now.prompt:
        return OperatorPrompt("WHICH?", _NEXT, now.prompt)
    if now.trouble or now.position is None:
        return OperatorPrompt("WAIT", _BAD, now.trouble or "no state yet")
    if now.got is not None:
        return OperatorPrompt(f"GOT {now.got}", _GOOD, f"sample {now.got} is on the disk")
    if now.enough or session.whole:
        more = "" if now.hands_free else f", {key} captures one more"
        why = f"; {now.enough}" if now.enough else ""
        return OperatorPrompt("ENOUGH", _GOOD, f"q finishes{more}{why}")
    done = session.counts[session.socket] >= session.target
    if done or now.leave:
        to = session.next_socket
        over = f"enough here: ball to socket {to}, then press s"
        return OperatorPrompt(f"SOCKET {to} NOW", _NEXT, over)
    if now.paused:
        to = session.socket
        return OperatorPrompt(f"SOCKET {to} NOW", _NEXT, f"once the ball is in socket {to}: {key}")
    return None


def _by_place(now: OperatorContext) -> OperatorPrompt | None:
    """Return what holds where no capture would be taken."""
    assert now.position is not None
    session = now.session
    left = session.left_behind(now.position)
    if left:
        return OperatorPrompt(f"SOCKET {session.socket} NOW", _NEXT, left)
    refusal = session.refusal(now.position) or now.doubt
    if refusal is None or now.fast:
        return None
    repeated = session.repeated(now.position) is not None
    return OperatorPrompt("NEXT POSE" if repeated else "MOVE", _CALM, refusal)


def _by_motion(now: OperatorContext) -> OperatorPrompt:
    """Return what holds at a new pose."""
    if now.moving:
        return OperatorPrompt(*(("MOVE", _CALM) if now.fast else ("HOLD", _STEADY)), now.moving)
    if now.push:
        return OperatorPrompt("LET GO", _BAD, f"the arm is being pushed: {now.push}")
    number = now.session.next_number
    if now.hands_free:
        return OperatorPrompt("HOLD", _STEADY, f"sample {number} is captured by itself")
    return OperatorPrompt("PRESS", _GOOD, f"{now.capture_key} captures sample {number}")

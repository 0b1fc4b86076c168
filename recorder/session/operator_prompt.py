"""View of a session, and the operator's next step: one or two words, and the reason.

docs/recording.md and docs/alarms.md list the words. The prompt never asks for a key that would be
refused.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

from ...errors import fixed
from .. import Configuration
from ..stream import JointLimits
from .alarms import Alarm, Alarms
from .guidance import Advice
from .session import Session

REACHED = math.radians(3)
"""A joint that is this near to the proposed pose need not move."""


@dataclass(frozen=True)
class OperatorPrompt:
    """The operator's next step."""

    words: str
    colour: str
    reason: str

    @property
    def text(self) -> str:
        """Both in one line."""
        return f"{self.words}: {self.reason}" if self.reason else self.words


@dataclass(frozen=True)
class View:
    """Snapshot of a session: all that a screen or a page shows."""

    session: Session
    position: Configuration | None = None
    """Joint positions where the arm rests, else of the last state that was not faulty [rad], [m];
    None before the first."""
    title: str = ""
    trouble: str | None = None
    """Reason why the stream cannot be trusted; None if it can."""
    moving: str | None = None
    """Reason why the arm does not count as still; None if it is still."""
    fast: bool = False
    """True while the arm moves so fast that it is being led on."""
    contact: str | None = None
    """Evidence that the arm is being pushed."""
    captured: int | None = None
    """Number of a sample that was captured a moment ago."""
    advice: Advice | None = None
    """Predicted quality of a calibration, and the best next step; the last that was given."""
    late: bool = False
    """True while advice is awaited for longer than usual."""
    page: str = ""
    """Address of the page beside the arm; empty without one."""
    implausible: str | None = None
    """Hands free: reason why this pose is not captured without a key."""
    hands_free: bool = False
    paused: bool = False
    """True while a key is awaited before anything is captured."""
    typed: str = ""
    """Line that is being typed; keys do not capture meanwhile."""
    question: str = ""
    """The operator is asked this, in a word or two, a colon, and the answers' keys."""
    alarm: Alarm | None = None
    """A fault that the samples show, and that was not answered."""
    kept: Alarms = ()
    """Faults whose samples the operator keeps as they are."""
    rate: float = 0.0
    """States per second."""
    age: float = math.inf
    """Time since the last state [s]."""
    missed: int = 0
    """States that were lost on the way."""
    drops: int = 0
    """Number of times that the connection was lost."""
    discarded: int = 0
    """Messages that the driver could not use."""
    resume_summary: tuple[str, ...] = ()
    """Lines on the recording that is continued, while the operator is asked about it."""
    help: bool = False
    """True to show the help in place of joints and captures."""
    scripted: bool = False
    """True if a script presses the keys."""

    @cached_property
    def prompt(self) -> OperatorPrompt:
        """The operator's next step."""
        prompt = _before_all(self) or _by_place(self) or _by_motion(self)
        return replace(prompt, reason=self.session.with_keys(prompt.reason))

    @cached_property
    def turns(self) -> tuple[tuple[JointLimits, float], ...]:
        """Joints that must turn for the proposed pose, and by how much [rad], [m], in chain order.

        None where no pose is proposed, or it is reached.
        """
        target = self.advice and self.advice.target
        if target is None or self.position is None:
            return ()
        joints = zip(self.session.joints, target, self.position, strict=True)
        turns = [(joint, goal - now) for joint, goal, now in joints]
        return tuple((joint, turn) for joint, turn in turns if abs(turn) > REACHED)

    @property
    def large(self) -> str:
        """The words that are read from afar: the two joints that turn most, while a hand leads.

        As in ``J5 -70 J2 +35``, in degrees or millimetres; of an alarm, after the key that it
        asks for.
        """
        if self.alarm and self.prompt.words == self.alarm.words:
            key = self.session.key_names[next(iter(self.alarm.answers))]
            return f"{key.upper()}: {self.alarm.words}"
        if self.prompt.words not in ("MOVE", "NEXT POSE") or not self.turns:
            return self.prompt.words
        largest = sorted(self.turns, key=lambda turn: -abs(turn[1]))[:2]
        numbers = {joint: i for i, joint in enumerate(self.session.joints, 1)}
        return " ".join(
            f"J{numbers[joint]} {fixed(joint.rounded(turn), 0, '+')}"
            for joint, turn in largest
        )


_CALM, _STEADY, _GOOD, _NEXT, _BAD = (
    "blue",
    "dark_orange3",
    "dark_green",
    "magenta",
    "red",
)


def _before_all(now: View) -> OperatorPrompt | None:
    """Return the step that does not depend on the arm's pose."""
    session, advice = now.session, now.advice
    if now.question:
        words, _, reason = now.question.partition(": ")
        return OperatorPrompt(words, _NEXT, reason)
    if now.typed:
        return OperatorPrompt("WHICH?", _NEXT, now.typed)
    if now.trouble or now.position is None:
        return OperatorPrompt("WAIT", _BAD, now.trouble or "no state yet")
    if now.captured:
        reason = f"sample {now.captured} is on the disk"
        return OperatorPrompt(f"GOT {now.captured}", _GOOD, reason)
    if now.alarm:
        return OperatorPrompt(now.alarm.words, _BAD, now.alarm.reason)
    hint = "" if now.hands_free else ", {capture} captures one more"
    leave = False
    if advice:
        leave = advice.leave and advice.socket == session.socket
        if advice.fails and (advice.exhausted or session.complete):
            return OperatorPrompt("SOLVE FAILS", _BAD, advice.fails)
        if advice.exhausted:
            why = "more poses here hardly help: {new}, base elsewhere"
            return OperatorPrompt("NEXT PLACE", _NEXT, why)
        if advice.enough:
            return OperatorPrompt("ENOUGH", _GOOD, _enough_for(session, advice, hint))
    if session.complete:
        words = "TARGET" if advice else "ENOUGH"
        return OperatorPrompt(words, _GOOD, f"{{finish}} finishes{hint}")
    target, reason = session.next_socket, ""
    if leave or session.turn_done or session.counts[session.socket] >= session.target:
        reason = f"enough here: ball to socket {target}, then press {{next}}"
    elif now.paused:
        target = session.socket
        reason = f"once the ball is in socket {target}: {{capture}}"
    return OperatorPrompt(f"SOCKET {target} NOW", _NEXT, reason) if reason else None


def _enough_for(session: Session, advice: Advice, hint: str) -> str:
    """Return what the samples are enough for, and what is asked beside them."""
    if session.sockets > 1 and not session.measured:
        return (
            "{measure} types the sockets' distance, without which solve gives no PASS; "
            "{finish} finishes"
        )
    if advice.near_only:
        return (
            "for this place: {finish} finishes; for all the workspace train on two: {new}, "
            "base elsewhere"
        )
    lacks = advice.alone and advice.unit == "mm"
    place = "; for PASS record another place" if lacks else ""
    return f"{{finish}} finishes{hint}; the goal is reached{place}"


def _by_place(now: View) -> OperatorPrompt | None:
    """Return the step at a pose where no capture would be taken."""
    assert now.position
    session = now.session
    samples = session.left_behind(now.position)
    if samples:
        return OperatorPrompt(f"BALL TO {session.socket}", _NEXT, samples)
    refusal = session.refusal(now.position) or now.implausible
    if refusal is None or now.fast:
        return None
    if refusal == now.implausible:
        return OperatorPrompt("MOVE", _CALM, refusal)
    if session.repeated(now.position) is None:
        return OperatorPrompt("OUT OF LIMITS", _BAD, refusal)
    last = session.last
    if last and session.same(last.position, now.position):
        refusal = f"sample {last.number} is taken; lead the arm to another pose"
    return OperatorPrompt("NEXT POSE", _CALM, refusal)


def _by_motion(now: View) -> OperatorPrompt:
    """Return the step at a new pose."""
    if now.moving:
        words, colour = ("MOVE", _CALM) if now.fast else ("HOLD", _STEADY)
        return OperatorPrompt(words, colour, now.moving)
    if now.contact:
        return OperatorPrompt("LET GO", _BAD, f"the arm is being pushed: {now.contact}")
    number = now.session.next_number
    if now.hands_free:
        return OperatorPrompt("HOLD", _STEADY, f"sample {number} is captured by itself")
    press = f"{{capture}} captures sample {number}"
    last, socket = now.session.last, now.session.socket
    if last is None or last.socket != socket:
        press += f", with the ball in socket {socket}"
    return OperatorPrompt("PRESS", _GOOD, press)

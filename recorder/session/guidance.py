"""Guidance of the operator: request and reply as values, their provider, and the client."""

import math
from dataclasses import dataclass, replace
from typing import Literal, Protocol

from ...drivers import clock
from .. import Configuration, Sample
from .actions import ALARM, DONE, ENOUGH, NEXT_PLACE, SessionActions, Sound
from .alarms import NO_ANSWERS, Alarm, Alarms, Answers
from .session import Session

LATE = 15.0
"""Longest time that an answer usually takes [s]."""
FOLLOWED = math.radians(45)
"""A sample with each joint this near to the proposed pose followed it [rad]."""
UNFOLLOWED = 3
"""So many proposals in a row that were not followed say that the arm gets no farther here."""
CONFINED = (
    "proposals were not followed: from now on poses near the samples alone "
    "(--turn DEG does so from the start)"
)
WORDS = {ENOUGH: "enough", NEXT_PLACE: "next place", DONE: "next socket"}
"""Words for the tones of an end."""
INFORMATIVE = 3
"""Samples from which on a prediction rests on more than the prior of the ball's place."""


@dataclass(frozen=True)
class GuidanceRequest:
    """State of the session that guidance is asked for."""

    samples: tuple[Sample, ...]
    """Those that count."""
    socket: int
    """The active one."""
    position: Configuration | None
    """Configuration of the arm [rad], [m] for a prismatic joint."""
    answers: Answers = NO_ANSWERS

    def is_like(self, request: "GuidanceRequest | None") -> bool:
        """Return whether two requests differ in the arm's configuration alone."""
        return request is not None and request == replace(
            self, position=request.position
        )

    def is_begin_of(self, session: Session) -> bool:
        """Return whether a session only went on since the request."""
        same = session.live[: len(self.samples)] == self.samples
        return same and session.distance == self.answers.distance


@dataclass(frozen=True)
class Advice:
    """Predicted quality of a calibration on the samples, and the best next step."""

    count: int
    """Number of samples that it rests on."""
    socket: int
    """The active socket that it was given for."""
    predicted: float
    """Upper end of the 68 % interval of the error of distances in the workspace [m]."""
    goal: float
    """Goal of the predicted error [m]."""
    fitted: bool = False
    """True if it rests on a fit to the samples, not on the nominal model alone."""
    last_error: float | None = None
    """Distance of the last sample from its socket's centre by the fit [m]."""
    mean_error: float | None = None
    """The mean of that over all samples [m]."""
    scale: float | None = None
    """Relative difference in size between the fitted arm and its model."""
    distance: float | None = None
    """Between the centres of sockets 0 and 1 by the fit [m]."""
    leave: bool = False
    """True if this socket has enough, and another has not."""
    enough: bool = False
    """True if the goal is reached, and no fault is seen."""
    near_only: bool = False
    """True if that is so near the recorded places, and not yet in the whole workspace."""
    alone: bool = True
    """True where no earlier placement is beside this one, which leaves nothing to hold out."""
    exhausted: bool = False
    """True if it is not reached, and more samples at this placement would hardly help."""
    target: Configuration | None = None
    """The configuration that would improve it most."""
    lift: bool = False
    """True if the ball must leave its socket on the way to the target."""
    alarms: Alarms = ()
    """Faults that the samples show, the most probable first."""
    early: bool = False
    """True if nothing but its alarms is known yet."""
    fails: str = ""
    """Reason for which these samples would be no valid calibration, beside what alarms say."""
    unit: Literal["mm", "mrad"] = "mm"
    """mrad where prediction and goal are of joints' zeros [rad], in place of distances."""
    closing: tuple[str, ...] = ()
    """Lines on the gain of another placement, once this one is enough."""
    route: tuple[tuple[int, Configuration], ...] = ()
    """Sockets and configurations of the samples to come, the target first."""

    def carried_on(self, session: Session) -> "Advice":
        """Return the advice for a session that went on since: the next pose that is not taken."""
        count, socket = len(session.live), session.socket
        is_open = self.target not in session.avoided
        if (count, socket) == (self.count, self.socket) and is_open:
            return self
        done = max(count - self.count, 0)
        passed = {*session.avoided, *(q for _, q in self.route[:done])}
        route = self.route[done:]
        ahead = [q for k, q in route if k == socket and q not in passed]
        poses = [q for q in ahead if not session.repeated(q)]
        return replace(self, target=next(iter(poses), None), lift=False, leave=False)

    @property
    def is_informative(self) -> bool:
        """True once the prediction rests on more than the prior of the ball's place."""
        return self.count >= INFORMATIVE


class GuidanceProvider(Protocol):
    """Source of advice that computes elsewhere, so that the recorder never waits for it."""

    @property
    def trouble(self) -> str | None:
        """Reason why no advice comes any more; None while it does."""
        ...

    @property
    def idle(self) -> bool:
        """True while a request can be made."""
        ...

    def ask(self, request: GuidanceRequest) -> None:
        """Make a request; never waits."""
        ...

    def answer(self) -> Advice | None:
        """Return the newest answer that has come since; None without one."""
        ...


class GuidanceClient:
    """Client of a provider: asks whenever samples or socket have changed, and never waits."""

    def __init__(
        self, provider: GuidanceProvider | None, actions: SessionActions, sound: Sound
    ) -> None:
        self._provider = provider
        self._actions = actions
        self._sound = sound
        self._advice: Advice | None = None
        self._request: GuidanceRequest | None = None
        self._asked_at = math.inf
        self._alarms: Alarms = ()
        self._kept: Alarms = ()
        self._proposals: tuple[int, tuple[Configuration, ...]] = 0, ()
        """Number of samples, and what was proposed since the last of them."""
        self._unfollowed = 0
        self._followed: tuple[Configuration, ...] = ()

    @property
    def advice(self) -> Advice | None:
        """The last that was given, as far as it holds for the session by now."""
        return self._advice and self._advice.carried_on(self._actions.session)

    @property
    def late(self) -> bool:
        """True while an answer is awaited for so long that the computer must be busy."""
        waits = self._provider is not None and not self._provider.idle
        return waits and clock.now() - self._asked_at > LATE

    @property
    def answers(self) -> Answers:
        """All that the operator has answered."""
        session = self._actions.session
        return Answers(
            self._kept,
            session.doubted_run,
            session.distance,
            session.avoided,
            self._followed,
            confined=self._unfollowed >= UNFOLLOWED,
        )

    @property
    def alarm(self) -> Alarm | None:
        """The most probable fault that the operator has not answered yet."""
        alarm = next(iter(self.answers.open_alarms(self._alarms)), None)
        if not alarm or not alarm.samples:
            return alarm
        session, first = self._actions.session, alarm.samples[0]
        before = [sample.number for sample in session.live if sample.number < first]
        since = range(before[-1] + 1, first + 1) if before else ()
        lost = not set(session.reconnected).isdisjoint(since)
        return alarm.after_reconnection() if lost else alarm

    def answered(self, alarm: Alarm, *, keep: bool = False) -> None:
        """Tell no more of a fault: its samples are kept as they are, or were put right."""
        if keep:
            self._kept = (*self._kept, alarm)
        self._alarms = tuple(a for a in self._alarms if not a.is_like(alarm))

    def update(self, position: Configuration | None) -> None:
        """Take an answer that has come, and ask anew for the arm's position if need be."""
        provider = self._provider
        if not provider:
            return
        self._accept(provider.answer())
        self._see_proposal()
        session = self._actions.session
        request = GuidanceRequest(session.live, session.socket, position, self.answers)
        if provider.idle and not request.is_like(self._request):
            self._request, self._asked_at = request, clock.now()
            provider.ask(request)
        if provider.trouble:
            self._actions.notify(
                f"no advice any more: {provider.trouble}; recording goes on"
            )
            self._provider = self._advice = None

    def _see_proposal(self) -> None:
        """Count the samples in a row that followed no proposal since the one before.

        A slow computer changes its proposal while the hand is on its way.
        """
        session = self._actions.session
        count, targets = self._proposals
        taken = session.live[count : count + 1]
        avoided = bool(targets) and targets[-1] in session.avoided
        followed = tuple(
            target
            for target in targets
            if taken and session.same(taken[0].position, target, FOLLOWED)
        )
        self._followed += followed
        if targets and (taken or avoided) and self._unfollowed < UNFOLLOWED:
            self._unfollowed = 0 if followed else self._unfollowed + 1
            if self._unfollowed == UNFOLLOWED:
                self._actions.notify(f"{UNFOLLOWED} {CONFINED}")
        target = self.advice and self.advice.target
        targets = () if taken or avoided else targets
        if target and target not in targets:
            targets = (*targets, target)
        self._proposals = len(session.live), targets

    def _accept(self, advice: Advice | None) -> None:
        """Take advice over, unless samples that it rests on have changed since the request.

        It holds while more are recorded: whoever is quick hears of faults as well.
        """
        session, request = self._actions.session, self._request
        if not advice or request is None or not request.is_begin_of(session):
            return
        alarm, before, self._alarms = self.alarm, self._advice, advice.alarms
        if not advice.early:
            self._advice = advice
        if self.alarm and not (alarm and alarm.cause == self.alarm.cause):
            self._actions.alarm(f"{self.alarm.words}: {self.alarm.text}", ALARM)
            return
        if advice.early:
            return
        if advice.fails and advice.fails != (before.fails if before else ""):
            self._actions.notify(f"solve would say FAIL: {advice.fails}")
        pattern = _pattern_of(advice, session)
        is_new = pattern != (before and _pattern_of(before, session))
        if pattern and is_new and not self.alarm:
            self._sound.play(pattern, WORDS[pattern])


def _pattern_of(advice: Advice, session: Session) -> str:
    """Return the tones for the end that advice tells; none where it tells none."""
    if advice.exhausted:
        return NEXT_PLACE
    if advice.enough:
        return ENOUGH
    return DONE if advice.leave and session.block is None else ""

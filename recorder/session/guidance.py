"""Guidance of the operator: request and reply as values, their provider, and the client."""

from dataclasses import dataclass
from typing import Literal, Protocol

from .. import Sample
from .actions import DONE, SessionActions, Sound

INFORMATIVE = 3
"""Samples from which on a prediction rests on more than the prior of the ball's place."""
NEAR = 2
"""Samples by which the begin of one fault may be told differently as more are recorded."""


@dataclass(frozen=True)
class GuidanceRequest:
    """State of the session that guidance is asked for."""

    samples: tuple[Sample, ...]
    """Those that count."""
    socket: int
    """The active one."""
    position: tuple[float, ...] | None
    """Configuration of the arm [rad], [m] for a prismatic joint."""


@dataclass(frozen=True)
class Alarm:
    """A fault that the samples show."""

    cause: Literal["base", "ball", "socket", "other"]
    words: str
    """It in a word or two."""
    text: str
    """It in a line, with the sample since which it holds."""
    samples: tuple[int, ...] = ()
    """Numbers of the samples that it concerns; none where it concerns all."""
    socket: int = 0
    """The one in which the ball truly was."""

    @property
    def reason(self) -> str:
        """The line, with the keys that cure it."""
        cures = {
            "base": "n new placement, ",
            "ball": "x take back, n base moved, ",
            "socket": "s mends it, ",
        }
        return f"{self.text}: {cures.get(self.cause, '')}k keep"

    def is_like(self, other: "Alarm") -> bool:
        """Return whether two alarms tell of one fault, which further samples locate better."""
        first, second = (*self.samples, 0)[0], (*other.samples, 0)[0]
        return self.cause == other.cause and abs(first - second) <= NEAR


@dataclass(frozen=True)
class Advice:
    """Predicted quality of a calibration on the samples, and the best next step."""

    count: int
    """Number of samples that it rests on."""
    socket: int
    """The active socket that it was given for."""
    predicted: float
    """Predicted error of distances in the workspace, the median of one standard deviation [m]."""
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
    exhausted: bool = False
    """True if it is not reached, and more samples at this placement would hardly help."""
    target: tuple[float, ...] | None = None
    """The configuration that would improve it most."""
    lift: bool = False
    """True if the ball must leave its socket on the way to the target."""
    gain: float = 0.0
    """Share by which the target would lower the predicted error."""
    alarms: tuple[Alarm, ...] = ()
    """Faults that the samples show, the most probable first."""
    early: bool = False
    """True if nothing but its alarms is known yet."""
    fails: str = ""
    """Reason for which these samples would be no valid calibration, beside what alarms say."""
    unit: Literal["mm", "mrad"] = "mm"
    """mrad where prediction and goal are of joints' zeros [rad], in place of distances."""
    closing: tuple[str, ...] = ()
    """Lines on the gain of another placement, once this one is enough."""

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
        self.advice: Advice | None = None
        """The last that was given, and still holds."""
        self._provider = provider
        self._actions = actions
        self._sound = sound
        self._asked: tuple[tuple[Sample, ...], int] | None = None
        self._alarms: tuple[Alarm, ...] = ()
        self._kept: list[Alarm] = []

    @property
    def alarm(self) -> Alarm | None:
        """The most probable fault that the operator has not answered yet."""
        return next((a for a in self._alarms if not any(map(a.is_like, self._kept))), None)

    def answered(self, alarm: Alarm, *, keep: bool = False) -> None:
        """Tell no more of a fault: its samples are kept as they are, or were put right."""
        if keep:
            self._kept.append(alarm)
        self._alarms = tuple(a for a in self._alarms if a != alarm)

    def update(self, position: tuple[float, ...] | None) -> None:
        """Take an answer that has come, and ask anew for the arm's position if need be."""
        if self._provider is None:
            return
        self._accept(self._provider.answer())
        session = self._actions.session
        asked = (session.live, session.socket)
        if self._provider.idle and asked != self._asked:
            self._asked = asked
            self._provider.ask(GuidanceRequest(session.live, session.socket, position))
        if self._provider.trouble:
            trouble = self._provider.trouble
            self._actions.notify(f"no advice any more: {trouble}; recording goes on")
            self._provider = self.advice = None

    def _accept(self, advice: Advice | None) -> None:
        """Take advice over, unless the session has changed since the request.

        Faults of its samples hold while more are recorded: whoever is quick hears of them as well.
        """
        session, (asked, _) = self._actions.session, self._asked or ((), 0)
        if advice is None or session.live[: len(asked)] != asked:
            return
        told, before, self._alarms = self.alarm, self.advice, advice.alarms
        holds = (advice.count, advice.socket) == (len(session.live), session.socket)
        if holds and not advice.early:
            self.advice = advice
        if self.alarm and not (told and told.cause == self.alarm.cause):
            self._actions.alarm(f"{self.alarm.words}: {self.alarm.text}")
            return
        if advice is not self.advice:
            return
        if advice.fails and advice.fails != (before.fails if before else ""):
            self._actions.notify(f"solve would say FAIL: {advice.fails}")
        done = (advice.enough or advice.exhausted or advice.leave) and not self.alarm
        if done and not (before and (before.enough or before.exhausted or before.leave)):
            self._sound.play(DONE)

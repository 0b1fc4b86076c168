"""The recorder: one loop that joins states, keys, session, file and screen."""

import signal
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

from ...drivers import clock
from .. import Sample
from ..session import (
    Advice,
    GuidanceClient,
    GuidanceProvider,
    OperatorContext,
    Recording,
    Session,
    SessionActions,
    Sound,
    StreamAlerts,
    View,
    readiness,
)
from ..stream import ContactDetector, StationaryPose, Stream, StreamMonitor
from .display import Display
from .key_bindings import KEYS, capture_key
from .key_handler import Controls
from .key_script import Script
from .keyboard import HangUp, Keyboard
from .signals import Signals

FRAME = 1 / 15
"""Time between two drawings of the screen [s]."""
MOST_STATES = 500
"""How many states are looked at in one go, so that keys and the screen need not wait for more."""
SHOWN = 1.0
"""How long a capture is shown large [s]."""


@dataclass(frozen=True)
class Outcome:
    """How a session ended."""

    session: Session
    signal: int | None
    """The signal that ended it; None where the operator did."""
    refused: int
    """How many captures were refused."""
    elsewhere: bool = False
    """Whether the operator goes on at a new placement."""
    advice: Advice | None = None
    """The last that was given."""


@dataclass
class Recorder:
    """One session at the robot: :meth:`run` it.

    A capture is on the disk before the session counts it, and so before the screen shows it.
    """

    session: Session
    stream: Stream
    watch: StreamMonitor
    recording: Recording
    display: Display
    title: str = ""
    keyboard: Keyboard | None = None
    script: Script | None = None
    push: ContactDetector | None = None
    check: Callable[[Sequence[Sample]], str | None] | None = None
    """Says what the last of some samples does that is odd by the model; None if nothing is."""
    plausible: Callable[[Sequence[Sample]], str | None] | None = None
    """Likewise, of a pose that is to be captured without a key."""
    keys: Mapping[str, str] = field(default_factory=lambda: KEYS)
    """What each key does."""
    hands_free: bool = False
    """Whether a settled rest at a new, plausible pose is captured without a key."""
    moved: bool = False
    """Whether the base was moved a moment ago, so that a key says when the ball is in it again."""
    sound: bool = True
    card: Sequence[str] = ()
    """What is continued, for the operator to confirm before anything is captured."""
    adviser: GuidanceProvider | None = None
    onlooker: Callable[[View], None] | None = None
    """Is shown every view too; must never wait."""

    def __post_init__(self) -> None:
        self._sound = Sound(self.display.bell, on=self.sound)
        self._desk = SessionActions(
            self.session, self.recording, self._sound, self.check, self.plausible
        )
        self._controls = Controls(
            self._desk,
            self.keys,
            self._capture,
            asking=bool(self.card),
            hands_free=self.hands_free,
            paused=self.hands_free or self.moved,
        )
        self._push = self.push or ContactDetector(self.session.joints)
        self._pushed: str | None = None
        self._pressed = 0.0
        self._got: tuple[int, float] | None = None
        self._shunned: StationaryPose | None = None
        self._doubted: StationaryPose | None = None
        self._news = StreamAlerts(self.stream, self.watch, self._desk)
        self._trouble = self._news.trouble
        self._consultation = GuidanceClient(self.adviser, self._desk, self._sound)
        self._next_frame = 0.0

    def run(self) -> Outcome:
        """Record until the operator finishes, a signal comes, or the terminal is gone.

        Raises:
            ScriptError: The key script is wrong, or waits for what does not come.
        """
        with Signals() as signals:  # first, so that no signal leaves the terminal as it is now
            received: int | None = None
            try:
                with self.display, self.keyboard or nullcontext():
                    while not self._desk.session.finished and signals.received is None:
                        self._wait(signals)
                        self._take_states()
                        self._follow(clock.now())
                        self._draw()
            except HangUp:
                received = signal.SIGHUP
            return Outcome(
                self._desk.session,
                signals.received or received,
                self._desk.refused,
                self._controls.elsewhere,
                self._consultation.advice,
            )

    # -- what comes in ---------------------------------------------------------------------------

    def _wait(self, signals: Signals) -> None:
        """Wait for a key, a signal, or the time to draw; read what there is."""
        sources: list[Signals | Keyboard | Script] = [signals]
        if self.keyboard:
            sources.append(self.keyboard)
        if self.script and self.script.hungry:
            sources.append(self.script)
        behind = self.stream.waiting > MOST_STATES
        pause = 0.0 if behind else max(0.0, self._next_frame - clock.now())
        ready = clock.wait(sources, pause)
        if signals in ready:
            signals.read()
        if self.script and self.script in ready:
            self.script.read()
        if self.keyboard and self.keyboard in ready:
            keys = self.keyboard.read()
            self._take_states()  # what came before the key was pressed
            for key in keys:
                self._press(key, clock.now())
            self._next_frame = 0.0

    def _take_states(self) -> None:
        """Look at the states that have come, in order, the oldest first."""
        for arrival, state, connection in self.stream.take(MOST_STATES):
            looked = self.watch.feed(state, arrival, connection)
            if looked and self.script:
                self._follow_script(self.script, arrival)
            if looked and self.hands_free:
                self._capture_by_itself(arrival)
            if self._desk.session.finished:
                return
        if self.script:
            self._follow_script(self.script, clock.now())

    def _follow(self, now: float) -> None:
        """Tell what has changed beside the arm, and sound what is due."""
        self._news.follow(now)
        self._pushed = self._push.look(self.watch.rest) if self.watch.rest else None
        latest = self.watch.latest
        self._consultation.go_on(latest.position if latest else None)
        self._sound.go_on(now)

    # -- keys ------------------------------------------------------------------------------------

    def _press(self, key: str, now: float) -> None:
        if self._desk.session.finished:
            return
        self._pressed = now
        withdrawn = self._desk.session.withdrawn
        self._controls.press(key)
        if self.hands_free and self._desk.session.withdrawn != withdrawn:
            self._shunned = self.watch.rest  # what was just taken back is not captured again

    def _capture(self) -> None:
        """Capture because a key says so."""
        rest = self.watch.rest
        reason = self._trouble(self._pressed) or (None if rest else self.watch.moving)
        if rest and not reason:
            reason = self._desk.session.refusal(rest.position)
        if not rest or reason:
            self._shunned = rest
            self._desk.refuse(reason or "still moving")
        else:
            self._save(rest)

    def _save(self, rest: StationaryPose) -> None:
        sample = self._desk.capture(rest, self._push.look(rest))
        self._shunned = None if sample else rest
        if sample:
            self._got = sample.number, clock.now()

    def _capture_by_itself(self, now: float) -> None:
        """Capture a settled rest at a new, plausible pose, unless a key is waited for."""
        rest = self.watch.rest
        if not rest or not self.watch.settled or self._trouble(now):
            return
        if self._same(self._shunned, rest):
            return
        moment = replace(self._moment(now), got=None)
        ready = readiness(moment)
        if ready.words == "HOLD":
            self._save(rest)
        elif moment.doubt and ready.reason == moment.doubt and not self._same(self._doubted, rest):
            self._doubted = rest  # said once
            self._desk.alarm(f"{moment.doubt} {moment.capture_key} captures it all the same")

    def _same(self, earlier: StationaryPose | None, rest: StationaryPose) -> bool:
        return bool(earlier and self._desk.session.same(earlier.position, rest.position))

    # -- keys from a script ----------------------------------------------------------------------

    def _follow_script(self, script: Script, now: float) -> None:
        """Press all keys of the script that are due."""
        stamp = self.watch.latest.stamp if self.watch.latest else 0.0
        while not self._desk.session.finished:
            key = script.due(now, stamp, self._no_new_rest(now))
            if key is None:
                break
            self._press(key, now)
        if script.over:
            self._controls.finish()

    def _no_new_rest(self, now: float) -> str | None:
        """Say why the arm does not rest where a script may capture; None if it does."""
        rest = self.watch.rest
        trouble = self._trouble(now) or (None if rest else self.watch.moving)
        if trouble or not (rest and self.watch.settled):
            return trouble or "not yet still for long enough"
        if self._same(self._shunned, rest):
            return "it rests where a capture was just refused"
        earlier = self._desk.session.nearest(rest.position)
        return earlier and f"it rests where sample {earlier.number} was taken"

    # -- what goes out ---------------------------------------------------------------------------

    def _moment(self, now: float) -> OperatorContext:
        """Return what the operator's next step follows from."""
        session, rest, latest = self._desk.session, self.watch.rest, self.watch.latest
        advice, here = self._consultation.advice, self._consultation.here
        got, prompt = self._got, self._controls.prompt
        return OperatorContext(
            session,
            position=rest.position if rest else latest and latest.position,
            trouble=self._trouble(now),
            moving=None if rest else self.watch.moving,
            fast=self.watch.fast,
            push=self._pushed,
            got=got[0] if got and now - got[1] < SHOWN else None,
            leave=bool(here and here.leave),
            enough=advice.why_enough if advice else "",
            doubt=self._doubt(rest) if rest and self.hands_free else None,
            hands_free=self.hands_free,
            paused=self._controls.paused,
            prompt=prompt.text if prompt else "",
            asking=self._controls.asking,
            capture_key=capture_key(self.keys),
        )

    def _doubt(self, rest: StationaryPose) -> str | None:
        """Say why a rest where a capture would be taken is not captured without a key."""
        refused = self._desk.session.refusal(rest.position)  # as often, where it was just captured
        return None if refused else self._desk.doubt(rest)

    def _draw(self) -> None:
        now = clock.now()
        if now < self._next_frame and not self._desk.session.finished:
            return
        self._next_frame = now + FRAME
        latest = self.watch.latest
        view = View(
            session=self._desk.session,
            title=self.title,
            ready=readiness(self._moment(now)),
            position=latest.position if latest else None,
            advice=self._consultation.advice,
            rate=self.watch.rate(now),
            age=self.watch.age(now),
            missed=self.stream.missed,
            drops=self.stream.drops,
            discarded=self.stream.rejected,
            card=tuple(self.card) if self._controls.asking else (),
            help=self._controls.help,
            scripted=self.script is not None,
        )
        self.display.show(view)
        if self.onlooker:
            self.onlooker(view)

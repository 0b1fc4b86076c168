"""The recorder: one loop that joins states, keys, session, file and screen."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

from ...drivers import clock
from .. import Sample
from ..session import (
    Check,
    GuidanceClient,
    GuidanceProvider,
    Recording,
    Session,
    SessionActions,
    Sound,
    StreamAlerts,
    View,
)
from ..stream import ContactDetector, StationaryPose, Stream, StreamMonitor
from .display import Lines, Screen
from .key_bindings import Script
from .key_handler import RESUME, KeyHandler, Outcome
from .keyboard import HANG_UP, HangUp, Keyboard, Signals

FRAME = 1 / 15
"""Time between two drawings of the screen [s]."""
MOST_STATES = 500
"""States taken in at once, at most, so that keys and the screen need not wait for more."""
MARGIN = 0.1
"""Time beyond a window of which a recorder that is behind still looks at states [s]."""
OLDEST_KEY = 1.0
"""Age beyond which a key is dropped: the arm may stand elsewhere by now [s]."""
SHOWN = 1.0
"""Duration of the banner of a capture [s]."""


@dataclass
class Recorder:
    """One session at the robot: :meth:`run` it.

    A capture is on the disk before the session counts it, and so before the screen shows it.
    """

    session: Session
    stream: Stream
    monitor: StreamMonitor
    recording: Recording
    display: Screen | Lines
    title: Callable[[Session], str] = lambda _: ""
    """First line of the screen."""
    keyboard: Keyboard | None = None
    script: Script | None = None
    contact: ContactDetector | None = None
    plausible: Check | None = None
    """Test of a pose that is to be captured without a key."""
    hands_free: bool = False
    """True to capture a settled rest at a new, plausible pose without a key."""
    moved: bool = False
    """True if the base was moved a moment ago: a key says when the ball is in it again."""
    sound: bool = True
    say: Callable[[str], None] | None = None
    """Says some words aloud; must never wait."""
    resume_summary: Sequence[str] = ()
    """Lines on the recording that is continued, to confirm before anything is captured."""
    guidance: GuidanceProvider | None = None
    page: str = ""
    """Address of the page beside the arm; empty without one."""
    observers: Sequence[Callable[[View], None]] = ()
    """Called with every view too; must never wait."""

    def __post_init__(self) -> None:
        self._sound = Sound(self.display.bell, on=self.sound, say=self.say)
        self._actions = SessionActions(
            self.session, self.recording, self._sound, self.plausible
        )
        self._client = GuidanceClient(self.guidance, self._actions, self._sound)
        self._handler = KeyHandler(
            self._actions,
            self._client,
            self._capture,
            question=RESUME if self.resume_summary else "",
            hands_free=self.hands_free,
            paused=self.hands_free or self.moved,
        )
        self._detector = self.contact or ContactDetector(self.session.joints)
        self._evidence: str | None = None
        self._pressed = 0.0
        self._captured: tuple[int, float] | None = None
        self._rejected: StationaryPose | None = None
        self._implausible: StationaryPose | None = None
        self._alerts = StreamAlerts(self.stream, self.monitor, self._actions)
        self._trouble = self._alerts.trouble
        self._next_frame = 0.0
        self._looked = clock.now()

    def run(self) -> Outcome:
        """Record until the operator finishes, a signal comes, or the terminal is gone."""
        # Signals come first, so that none leaves the terminal as it is now.
        with Signals() as signals:
            received: int | None = None
            actions = self._actions
            try:
                with self.display, self.keyboard or nullcontext():
                    while not actions.session.finished and signals.received is None:
                        self._wait(signals)
                        self._take_states()
                        self._draw()
            except HangUp:
                received = HANG_UP
            signal = signals.received or received
            return Outcome(
                actions.session,
                signal,
                actions.refused,
                actions.successor,
                self._client.advice,
            )

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
        held_up = clock.now() - self._looked
        self._looked += held_up
        if signals in ready:
            signals.read()
        if signals.continued:
            signals.continued = False
            self.display.restore()
            if self.keyboard:
                self.keyboard.restore()
        if self.script and self.script in ready:
            self.script.read()
        if self.keyboard and self.keyboard in ready:
            keys = self.keyboard.read()
            self._take_states()  # those that came before the key was pressed
            if held_up > OLDEST_KEY:
                why = f"the recorder was held up for {held_up:.1f} s; press again"
                self._actions.alarm(f"dropped {' '.join(keys)}: {why}")
                keys = []
            for key in keys:
                self._press(key, clock.now())
            self._next_frame = 0.0

    def _take_states(self) -> None:
        """Take in the states that have come, in order, the oldest first."""
        if self.monitor.live:  # a busy computer; the newest alone say where the arm is
            self.stream.catch_up(self.monitor.length + MARGIN)
        for arrival, state, connection in self.stream.take(MOST_STATES):
            averaged = self.monitor.feed(state, arrival, connection)
            if averaged and self.script:
                self._follow_script(self.script, arrival)
            if averaged and self.hands_free:
                self._capture_hands_free(arrival)
            if self._actions.session.finished:
                return
        if self.script:
            self._follow_script(self.script, clock.now())

    def _press(self, key: str, now: float) -> None:
        if self._actions.session.finished:
            return
        self._pressed = now
        withdrawn = self._actions.session.withdrawn
        self._handler.press(key)
        if self.hands_free and self._actions.session.withdrawn != withdrawn:
            # A sample just taken back is not captured again.
            self._rejected = self.monitor.rest

    def _capture(self) -> None:
        """Capture because a key says so."""
        pose = self.monitor.rest
        reason = self._trouble(self._pressed) or (None if pose else self.monitor.moving)
        if pose and not reason:
            reason = self._actions.session.refusal(pose.position)
        if not pose or reason:
            self._rejected = pose
            self._actions.refuse(reason or "still moving")
        else:
            self._save(pose)

    def _save(self, pose: StationaryPose) -> None:
        sample = self._actions.capture(pose, self._detector.evidence(pose))
        self._rejected = None if sample else pose
        if sample:
            self._captured = sample.number, clock.now()

    def _capture_hands_free(self, now: float) -> None:
        """Capture a settled rest at a new, plausible pose, unless a key is awaited."""
        pose = self.monitor.rest
        if not (pose and self.monitor.settled) or self._trouble(now):
            return
        if self._same(self._rejected, pose):
            return
        view = replace(self._view(now), captured=None)
        odd = view.implausible
        if view.prompt.words == "HOLD":
            self._save(pose)
        elif (
            odd
            and view.prompt.reason == odd
            and not self._same(self._implausible, pose)
        ):
            self._implausible = pose  # alarmed once
            self._actions.alarm(f"{odd} {{capture}} captures it all the same")

    def _same(
        self, reference: StationaryPose | Sample | None, pose: StationaryPose
    ) -> bool:
        same = self._actions.session.same
        return reference is not None and same(reference.position, pose.position)

    def _follow_script(self, script: Script, now: float) -> None:
        """Press all keys of the script that are due."""
        stamp = self.monitor.latest.stamp if self.monitor.latest else 0.0
        while not self._actions.session.finished:
            key = script.due(now, stamp, self._no_new_rest(now))
            if key is None:
                break
            self._press(key, now)
        if script.over:
            self._handler.finish()

    def _no_new_rest(self, now: float) -> str | None:
        """Return the reason why the arm does not rest where a script may capture, or None."""
        pose = self.monitor.rest
        trouble = self._trouble(now) or (None if pose else self.monitor.moving)
        if trouble or not (pose and self.monitor.settled):
            return trouble or "not yet still for long enough"
        if self._same(self._rejected, pose):
            return "it rests where a capture was just refused"
        for sample in self._actions.session.live:
            if self._same(sample, pose):
                return f"it rests where sample {sample.number} was taken"
        return None

    def _view(self, now: float) -> View:
        """Return the state of the session, from which the operator's next step follows."""
        pose, latest = self.monitor.rest, self.monitor.latest
        captured, line = self._captured, self._handler.line
        asks = self._handler.question == RESUME
        by_itself = pose if self.hands_free else None
        if by_itself and self._actions.session.refusal(by_itself.position):
            by_itself = None  # often: it was just captured
        return View(
            self._actions.session,
            position=pose.position if pose else latest and latest.position,
            title=self.title(self._actions.session),
            trouble=self._trouble(now),
            moving=None if pose else self.monitor.moving,
            fast=self.monitor.fast,
            contact=self._evidence,
            captured=captured[0] if captured and now - captured[1] < SHOWN else None,
            advice=self._client.advice,
            implausible=self._actions.implausible(by_itself) if by_itself else None,
            hands_free=self.hands_free,
            paused=self._handler.paused,
            typed=line.text if line else "",
            question=self._handler.question,
            alarm=self._client.alarm,
            kept=self._client.answers.kept,
            late=self._client.late,
            page=self.page,
            rate=self.monitor.rate(now),
            age=self.monitor.age(now),
            missed=self.stream.missed,
            drops=self.stream.drops,
            discarded=self.stream.rejected,
            resume_summary=tuple(self.resume_summary) if asks else (),
            help=self._handler.help,
            scripted=self.script is not None,
        )

    def _draw(self) -> None:
        """Update alerts, guidance and sound, and draw what they say by now."""
        now = clock.now()
        self._alerts.update(now)
        pose, latest = self.monitor.rest, self.monitor.latest
        self._evidence = self._detector.evidence(pose) if pose else None
        self._client.update(latest.position if latest else None)
        self._sound.update(now)
        if now < self._next_frame and not self._actions.session.finished:
            return
        self._next_frame = now + FRAME
        view = self._view(now)
        self.display.show(view)
        for observer in self.observers:
            observer(view)

"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import math
from collections.abc import Generator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

from ...recorder import (
    DEFAULT_DISTANCE,
    StreamLog,
    next_log_file,
)
from ...recorder.session import BLOCK, Session
from ...recorder.stream import STILL, ContactDetector, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, Speech, keys_with
from ..cli import Terminal, one_arm
from .checks import gravity_of, odd_pose
from .guidance_process import BackgroundGuidance
from .neighbours import recorded_beside
from .options import RecordOptions
from .session_start import SessionStart


def record_session(start: SessionStart) -> Outcome:
    """Record at one placement until the operator finishes."""
    with ExitStack() as stack:
        return _recorder(start, stack).run()


def _recorder(start: SessionStart, stack: ExitStack) -> Recorder:
    """Return the recorder of a session; what it opens is closed by the stack."""
    options, hand = start.options, start.hand
    distance = start.metadata.distance or DEFAULT_DISTANCE
    keys = keys_with(options.key)
    gravity = gravity_of(start.robot, options.load.validated().load)
    base_moved = False
    if start.recording:
        stack.enter_context(start.recording)
        base_moved = not start.recording.content.samples
    keyboard, script = options.open_keys(stack)
    stack.enter_context(_undisturbed())
    start.terminal.say_at_once(f"connecting to {options.driver} ...")
    speech = stack.enter_context(closing(Speech())) if options.say else None
    driver = start.connect()
    stack.enter_context(driver)
    still = options.still
    if still is None:
        still = max(STILL, driver.resolution)
    stream = stack.enter_context(closing(Stream(driver)))
    recording = stack.enter_context(start.open_recording(still))
    if options.keep_stream:
        stream.log = _stream_log(start, stack)
    by_hand = keyboard is not None and script is None
    session = replace(start.first_session(recording, driver.remark), keys=keys)
    guidance = None
    if by_hand and not (options.no_guide or options.quick):
        guidance = stack.enter_context(closing(_guidance(start, distance)))
        session = replace(session, block=None if options.calibration else BLOCK)
    if hand:
        hand.guided = guidance is not None
        if base_moved:
            hand.move_base()
    live, resolution = script is None, driver.resolution
    monitor = StreamMonitor(
        session.joints, options.window, still, live=live, resolution=resolution
    )
    return Recorder(
        session,
        stream,
        monitor,
        recording,
        _display(start.terminal),
        partial(_title, options, start.metadata.robot),
        keyboard,
        script,
        ContactDetector(session.joints, gravity),
        partial(odd_pose, start.robot, distance),
        hands_free=options.auto,
        moved=base_moved,
        sound=options.sound != "off",
        say=speech,
        guidance=guidance,
        observers=[*filter(None, (start.page, hand and hand.follow))],
        page=start.page.url if start.page else "",
        resume_summary=start.summary(recording, session) if by_hand else (),
    )


def _stream_log(start: SessionStart, stack: ExitStack) -> StreamLog:
    """Return the file of the stream, closed at the end, when its trouble is said."""
    log = StreamLog(next_log_file(start.options.out), start.robot.joint_names)
    stack.callback(lambda: start.terminal.warn(*filter(None, [log.trouble])))
    stack.callback(log.close)
    return log


def _guidance(start: SessionStart, distance: float) -> BackgroundGuidance:
    options = start.options
    settings: dict[str, Any] = {
        "distance": distance,
        "sockets": start.metadata.sockets,
        "turn": math.inf if options.turn is None else math.radians(options.turn),
    }
    if options.calibration:
        settings["calibration"] = one_arm(options.calibration)
        settings["target"] = options.samples
    else:
        settings["goal"] = None if options.goal_mm is None else 1e-3 * options.goal_mm
        settings["parts"] = recorded_beside(options.out, start.robot)
        settings["lost"] = start.lost
    return BackgroundGuidance(options, **settings)


def _title(options: RecordOptions, robot: str, session: Session) -> str:
    out = str(options.out)
    folder = out if len(out) <= 36 else f"…{out[-35:]}"
    distance = session.distance
    distance_text = "unmeasured" if distance is None else f"{1e3 * distance:g} mm"
    return f"{robot}  {folder}  sockets {distance_text}  {options.driver}"


@contextmanager
def _undisturbed() -> Generator[None]:
    """Keep the library's log off the screen, and garbage collection off all that is loaded."""
    log = logging.getLogger("mukca")
    before = (log.handlers, log.propagate)
    frozen = gc.get_freeze_count() > 0
    log.handlers, log.propagate = [*log.handlers, logging.NullHandler()], False
    gc.collect()  # it stops reading for 0.1 s
    gc.freeze()
    try:
        yield
    finally:
        log.handlers, log.propagate = before
        if not frozen:
            gc.unfreeze()


def _display(terminal: Terminal) -> Screen | Lines:
    console = terminal.console
    full_screen = console.is_terminal and not console.is_dumb_terminal
    if full_screen and console.file.isatty():
        return Screen(console)
    return Lines(console, brief=terminal.brief)

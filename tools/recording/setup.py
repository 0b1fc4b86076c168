"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import math
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from ...recorder import DEFAULT_DISTANCE, Metadata, Sample, StreamLog, next_log_file
from ...recorder.stream import STILL, ContactDetector, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, keys_with
from ...solver.robot import Robot
from ..cli import Terminal, one_arm
from . import session_start
from .checks import gravity_of, odd_pose
from .guidance_process import BackgroundGuidance
from .options import RecordOptions, joints_of

if TYPE_CHECKING:
    from .page import PageProcess


def record_session(
    options: RecordOptions,
    metadata: Metadata,
    robot: Robot,
    terminal: Terminal,
    samples: Sequence[Sample] | None = None,
    page: "PageProcess | None" = None,
    hand: session_start.FollowingHand | None = None,
) -> Outcome:
    """Record at one placement until the operator finishes.

    At a further placement of the same run, ``samples`` are the samples since the base moved there;
    the page goes on at its address, and the hand of a simulated arm leads on.
    """
    keys = keys_with(options.key)
    base_moved = samples is not None and not samples
    gravity = gravity_of(robot, options.load.validated().load)
    with ExitStack() as stack:
        keyboard, script = session_start.keys_of(options, stack)
        stack.enter_context(_undisturbed())
        terminal.say_at_once(f"connecting to {options.driver} ...")
        driver = session_start.connect(options.driver, robot, hand)
        stack.enter_context(driver)
        still = max(STILL, driver.resolution) if options.still is None else options.still
        stream = stack.enter_context(closing(Stream(driver)))
        recording = stack.enter_context(session_start.open_recording(options, metadata, still))
        stream.log = _stream_log(options, robot, terminal, stack)
        monitor = _monitor(options, robot, still, driver.resolution, live=script is None)
        by_hand = keyboard is not None and script is None
        session = session_start.first_session(options, metadata, robot, recording, samples or ())
        session = session_start.announced(session, options, driver.remark, page)
        guidance = None
        if by_hand and not (options.no_guide or options.quick):
            guidance = stack.enter_context(closing(_guidance(options, metadata, robot)))
            session = session_start.with_blocks(options, session)
        if hand:
            hand.guided = guidance is not None
            if base_moved:
                hand.move_base()
        summary = session_start.summary_of(recording, session, metadata.distance) if by_hand else ()
        return Recorder(
            session=session,
            stream=stream,
            monitor=monitor,
            recording=recording,
            display=_display(terminal),
            title=_title(options, metadata),
            keyboard=keyboard,
            script=script,
            contact=ContactDetector(session.joints, gravity),
            plausible=partial(odd_pose, robot, metadata.distance or DEFAULT_DISTANCE),
            keys=keys,
            hands_free=options.auto,
            moved=base_moved,
            sound=options.sound != "off",
            guidance=guidance,
            observers=[*filter(None, (page, hand and hand.follow))],
            page=page.url if page else "",
            resume_summary=summary,
        ).run()


def _stream_log(
    options: RecordOptions, robot: Robot, terminal: Terminal, stack: ExitStack
) -> StreamLog | None:
    """Return the file of the stream, closed at the end, when its trouble is said; None for none."""
    if not options.keep_stream:
        return None
    log = StreamLog(next_log_file(options.out), robot.joint_names)
    stack.callback(lambda: terminal.warn(*([log.trouble] if log.trouble else [])))
    stack.callback(log.close)
    return log


def _monitor(
    options: RecordOptions, robot: Robot, still: float, resolution: float, *, live: bool
) -> StreamMonitor:
    return StreamMonitor(
        joints_of(robot), window=options.window, still=still, live=live, resolution=resolution
    )


def _guidance(options: RecordOptions, metadata: Metadata, robot: Robot) -> BackgroundGuidance:
    settings: dict[str, Any] = {
        "distance": metadata.distance or DEFAULT_DISTANCE,
        "sockets": metadata.sockets,
        "turn": math.inf if options.turn is None else math.radians(options.turn),
    }
    if options.calibration is not None:
        settings |= {"calibration": one_arm(options.calibration), "target": options.samples}
    else:
        goal = None if options.goal_mm is None else 1e-3 * options.goal_mm
        settings |= {"goal": goal, "parts": session_start.recorded_beside(options.out, robot)}
    return BackgroundGuidance(options, **settings)


def _title(options: RecordOptions, metadata: Metadata) -> str:
    out, distance = str(options.out), metadata.distance
    folder = out if len(out) <= 36 else f"…{out[-35:]}"
    distance_text = "unmeasured" if distance is None else f"{1e3 * distance:g} mm"
    return f"{metadata.robot}  {folder}  sockets {distance_text}  {options.driver}"


@contextmanager
def _undisturbed() -> Generator[None, None, None]:
    """Keep the library's log off the screen, and garbage collection off all that is loaded."""
    log = logging.getLogger("mukca")
    before, frozen = (log.handlers, log.propagate), gc.get_freeze_count() > 0
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

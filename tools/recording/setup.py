"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import sys
import time
from collections.abc import Generator
from contextlib import ExitStack, closing, contextmanager

from ...recorder.session import Recording, Session
from ...recorder.stream import STILL, ContactDetector, JointLimits, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, keys_with
from ...solver.robot import Robot
from ..cli import Terminal
from .guidance_process import BackgroundGuidance, goal_for
from .options import SettledOptions
from .outlier_checks import FIRST_FAR, gravity_of, outlier_check, similar_models
from .page import PageProcess
from .resources import connect, keys_of, open_log, open_recording


def joints_of(robot: Robot) -> tuple[JointLimits, ...]:
    """Return the limits of the chain's actuated joints."""
    return tuple(
        JointLimits(joint.name, joint.lower, joint.upper, prismatic=joint.type == "prismatic")
        for joint in robot.actuated
    )


def record_session(
    options: SettledOptions, robot: Robot, terminal: Terminal, *, moved: bool = False
) -> Outcome:
    """Record at one placement until the operator finishes.

    Args:
        options: Of ``mukca record``, with nothing left open.
        robot: The nominal robot.
        terminal: For lines to people.
        moved: True if the base was moved a moment ago.
    """
    joints, keys = joints_of(robot), keys_with(options.key)
    with ExitStack() as stack:
        keyboard, script = keys_of(options, stack)
        stack.enter_context(_undisturbed())
        if sys.stdout.isatty():
            terminal.say(f"connecting to {options.driver} ...")
            sys.stdout.flush()
        driver = stack.enter_context(connect(options.driver, robot.joint_names))
        still = max(STILL, driver.resolution) if options.still is None else options.still
        stream = stack.enter_context(closing(Stream(driver)))
        recording = stack.enter_context(open_recording(options, robot, joints, still))
        if options.keep_stream:
            stack.enter_context(open_log(stream, options, robot, terminal))
        live = script is None
        monitor = StreamMonitor(
            joints, window=options.window, still=still, live=live, resolution=driver.resolution
        )
        session = _session(options, robot, joints, recording)
        page = PageProcess(options, options.page_host) if options.page else None
        if page is not None:
            stack.enter_context(closing(page))
            session = _with_address(session, page.url, options.page_host)
        guidance: BackgroundGuidance | None = None
        if keyboard is not None and live and not options.no_guide:
            goal = goal_for(robot, options.goal_mm)
            guidance = BackgroundGuidance(options, options.distance, options.sockets, goal)
            stack.enter_context(closing(guidance))
        return Recorder(
            session=session,
            stream=stream,
            monitor=monitor,
            recording=recording,
            display=_display(terminal),
            title=_title(options, robot),
            keyboard=keyboard,
            script=script,
            contact=ContactDetector(joints, gravity_of(robot, options.load.validated().load)),
            check=outlier_check(robot, options.distance),
            plausible=outlier_check(robot, options.distance, far=FIRST_FAR),
            keys=keys,
            hands_free=options.auto,
            moved=moved,
            sound=options.sound != "off",
            guidance=guidance,
            observer=page,
            resume_summary=_resume_summary(session, options) if keyboard and live else (),
        ).run()


def _with_address(session: Session, url: str, host: str) -> Session:
    """Return the session with messages on the page's address."""
    session = session.with_message(f"page: {url}")
    if host in ("127.0.0.1", "localhost", "::1"):
        return session
    warning = "whoever knows this address can watch, from anywhere in the network"
    return session.with_message(warning, alarm=True)


def _title(options: SettledOptions, robot: Robot) -> str:
    out = str(options.out)
    folder = out if len(out) <= 36 else f"…{out[-35:]}"
    return f"{robot.name}  {folder}  sockets {1e3 * options.distance:g} mm  {options.driver}"


def _resume_summary(session: Session, options: SettledOptions) -> tuple[str, ...]:
    """Return the recording that is continued, in lines; none at a new placement."""
    if not session.samples:
        return ()
    counts = ", ".join(f"{count} in socket {k}" for k, count in enumerate(session.counts))
    last = session.samples[-1].time
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(last)) if last else "at an unknown time"
    return (
        f"Continues {counts}; the last {when}; in {options.out}",
        f"Sockets {1e3 * options.distance:g} mm apart. The ball was last in socket "
        f"{session.socket}.",
        "Has the base not moved since?",
    )


@contextmanager
def _undisturbed() -> Generator[None, None, None]:
    """Keep the library's log off the screen, and garbage collection off all that is loaded."""
    log, handler = logging.getLogger("mukca"), logging.NullHandler()
    propagate, frozen = log.propagate, gc.get_freeze_count() > 0
    log.addHandler(handler)
    log.propagate = False
    gc.collect()  # it stops reading for 0.1 s
    gc.freeze()
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate = propagate
        if not frozen:
            gc.unfreeze()


def _session(
    options: SettledOptions,
    robot: Robot,
    joints: tuple[JointLimits, ...],
    recording: Recording,
) -> Session:
    """Return the session as an earlier start left it."""
    content = recording.content
    session = Session(
        joints,
        sockets=options.sockets,
        target=options.target,
        socket=min(recording.socket, options.sockets - 1),
        samples=content.samples,
        withdrawn=content.withdrawn,
        similar_models=similar_models(robot),
    )
    for remark in recording.remarks:
        session = session.with_message(remark, alarm=True)
    if session.samples:
        session = session.with_message(f"continues a recording of {len(session.live)} samples")
    return session


def _display(terminal: Terminal) -> Screen | Lines:
    console = terminal.console
    whole = console.is_terminal and not console.is_dumb_terminal
    if whole and console.file.isatty():
        return Screen(console)
    return Lines(console, brief=terminal.brief)

"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import math
import sys
from collections.abc import Generator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

from ...recorder.stream import STILL, ContactDetector, JointLimits, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, keys_with
from ...solver.robot import Robot
from ..cli import Terminal, one_arm
from . import session_start
from .checks import gravity_of, outlier_check, similar_models
from .guidance_process import BackgroundGuidance
from .options import SettledOptions


def joints_of(robot: Robot) -> tuple[JointLimits, ...]:
    """Return the limits of the chain's actuated joints."""
    return tuple(
        JointLimits(joint.name, joint.lower, joint.upper, prismatic=joint.type == "prismatic")
        for joint in robot.actuated
    )


def record_session(
    options: SettledOptions,
    robot: Robot,
    terminal: Terminal,
    before: session_start.Before | None = None,
) -> Outcome:
    """Record at one placement until the operator finishes, after others of the same run."""
    earlier = before or session_start.Before()
    joints, keys = joints_of(robot), keys_with(options.key)
    with ExitStack() as stack:
        keyboard, script = session_start.keys_of(options, stack)
        stack.enter_context(_undisturbed())
        if sys.stdout.isatty():
            terminal.say(f"connecting to {options.driver} ...")
            sys.stdout.flush()
        driver = stack.enter_context(session_start.connect(options.driver, robot))
        still = max(STILL, driver.resolution) if options.still is None else options.still
        stream = stack.enter_context(closing(Stream(driver)))
        recording = stack.enter_context(session_start.open_recording(options, robot, joints, still))
        if options.keep_stream:
            stack.enter_context(session_start.open_log(stream, options, robot, terminal))
        live = script is None
        monitor = StreamMonitor(
            joints, window=options.window, still=still, live=live, resolution=driver.resolution
        )
        session = session_start.first_session(
            options, similar_models(robot), joints, recording, earlier.moved
        )
        page = None
        if options.page:
            from .page import PageProcess

            page = stack.enter_context(closing(PageProcess(options, options.page_host)))
            session = session_start.with_address(session, page.url, options.page_host)
        guided = keyboard is not None and live and not options.no_guide
        guidance = stack.enter_context(closing(_guidance(options, robot))) if guided else None
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
            plausible=outlier_check(robot, options.distance),
            keys=keys,
            hands_free=options.auto,
            moved=before is not None and not before.moved,
            sound=options.sound != "off",
            guidance=guidance,
            observer=page,
            resume_summary=session_start.resume_summary_of(recording, session, options)
            if keyboard and live
            else (),
        ).run()


def _guidance(options: SettledOptions, robot: Robot) -> BackgroundGuidance:
    turn = math.inf if options.turn is None else math.radians(options.turn)
    settings: dict[str, Any] = {"distance": options.distance, "sockets": options.sockets}
    if options.calibration is not None:
        settings |= {"calibration": one_arm(options.calibration), "target": options.target}
    else:
        goal = None if options.goal_mm is None else 1e-3 * options.goal_mm
        settings |= {"goal": goal, "earlier": session_start.recorded_beside(options.out, robot)}
    return BackgroundGuidance(options, **settings, turn=turn)


def _title(options: SettledOptions, robot: Robot) -> str:
    out = str(options.out)
    folder = out if len(out) <= 36 else f"…{out[-35:]}"
    apart = f"sockets {1e3 * options.distance:g} mm" if options.stated else "sockets unmeasured"
    return f"{robot.name}  {folder}  {apart}  {options.driver}"


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
    whole = console.is_terminal and not console.is_dumb_terminal
    if whole and console.file.isatty():
        return Screen(console)
    return Lines(console, brief=terminal.brief)

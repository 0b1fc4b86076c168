"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import math
from collections.abc import Generator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

from ...recorder import (
    DEFAULT_DISTANCE,
    METADATA,
    READINGS_CHANGED,
    SAMPLES,
    Placement,
    RecordingError,
    StreamLog,
    next_log_file,
    read_metadata,
    read_placement,
    read_sessions,
)
from ...recorder.session import BLOCK, Session
from ...recorder.stream import STILL, ContactDetector, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, Speech, keys_with
from ...solver.identification.robot import Robot
from ..cli import Terminal, one_arm
from .checks import gravity_of, odd_pose
from .guidance_process import BackgroundGuidance
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
    session = start.first_session(recording, driver.remark)
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
        keys,
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


PRACTICE = "mock"
"""Driver of simulated arms: its address is a file of poses, not an arm's."""


def driver_elsewhere(driver: str) -> str | None:
    """Return a driver with the base elsewhere; None for a simulated arm with no base left.

    A simulated arm stays at the base of its folder, so the next folder beside it has another.
    """
    name, _, address = driver.partition(":")
    if name != PRACTICE:
        return driver
    path, mark, options = address.partition("?")
    here = Path(path)
    for folder in sorted({file.parent for file in here.parent.glob("*/*.csv")}):
        if folder > here and _origin(folder).get("driver") != PRACTICE:
            return f"{PRACTICE}:{folder}{mark}{options}"
    return None


def recorded_beside(out: Path, robot: Robot) -> tuple[Placement, ...]:
    """Return the earlier placements of this arm in neighbouring folders, oldest first.

    Those of another model are left out, and those whose :func:`_origin` is another. So are those
    before joints read otherwise: they tell nothing of the readings now.
    """
    if read_metadata(out / METADATA).get(READINGS_CHANGED) is True:
        return ()
    origin = _origin(out)
    earlier: list[tuple[float, bool, Placement]] = []  # begin [s], readings changed
    for file in out.parent.glob(f"*/{SAMPLES}"):
        folder = file.parent
        if folder.resolve() == out.resolve():
            continue
        with suppress(RecordingError):
            metadata = read_metadata(folder / METADATA)
            origin_there = _origin(folder)
            names = origin.keys() & origin_there.keys()
            is_same = all(origin[name] == origin_there[name] for name in names)
            if is_same and metadata.get("model_sha256") == robot.sha256:
                placement = read_placement(folder).for_joints(robot.joint_names)
                changed = metadata.get(READINGS_CHANGED) is True
                earlier.append((placement.samples[0].time or 0.0, changed, placement))
    placements: list[Placement] = []
    for _, changed, placement in sorted(earlier, key=itemgetter(0)):
        placements = [*([] if changed else placements), placement]
    return tuple(placements)


def _origin(folder: Path) -> dict[str, object]:
    """Return what tells one arm's placements from another's, as far as it was written down.

    These are the robot's name, its serial number and its address, each as last written. A session
    in one socket has another purpose than one in several.
    """
    file = folder / METADATA
    origin = {**read_metadata(file)}
    for session in read_sessions(file):
        origin |= session
    driver = origin.get("driver")
    if isinstance(driver, str) and driver.partition(":")[0] == PRACTICE:
        origin["driver"] = PRACTICE
    if "sockets" in origin:
        origin["one_socket"] = origin["sockets"] == 1
    names = ("robot_name", "serial_number", "driver", "one_socket")
    return {name: origin[name] for name in names if name in origin}

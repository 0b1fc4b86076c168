"""Start of a session: its keys, driver and files; anew, or as an earlier one left it."""

import sys
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ... import recorder
from ...drivers import Reconnecting, open_driver
from ...recorder.session import BLOCK, Recording, Session
from ...recorder.terminal import ConsoleKeyboard, Keyboard, Script
from ...solver import calibration
from ...solver import robot as robots
from ..simulation import FollowingHand, practice_driver
from .checks import similar_models
from .options import RecordOptions, has_keyboard, joints_of

if TYPE_CHECKING:
    from .page import PageProcess

LOCAL_HOSTS = ("127.0.0.1", "localhost", "::1")
NOTES = ("operator", "serial_number", "warm_up", "temperature", "notes")


def with_blocks(options: RecordOptions, session: Session) -> Session:
    """Return a guided session, whose sockets change after each block of samples."""
    return replace(session, block=None if options.calibration else BLOCK)


def first_session(
    options: RecordOptions,
    metadata: recorder.Metadata,
    robot: robots.Robot,
    recording: Recording,
    samples: Sequence[recorder.Sample],
) -> Session:
    """Return the session as an earlier start left it, with samples of a base that moved."""
    content = recording.content
    first = len(content.samples) + 1
    samples = [replace(sample, number=i) for i, sample in enumerate(samples, first)]
    for sample in samples:
        recording.capture(sample)
    socket = samples[-1].socket if samples else recording.socket
    session = Session(
        joints_of(robot),
        sockets=metadata.sockets,
        measured=metadata.measured or metadata.sockets == 1,
        target=options.samples,
        socket=min(socket, metadata.sockets - 1),
        samples=(*content.samples, *samples),
        withdrawn=content.withdrawn,
        similar_models=partial(similar_models, robot),
    )
    for remark in recording.remarks:
        session = session.with_message(remark, alarm=True)
    if samples:
        since = "joints read otherwise" if metadata.readings_changed else "the base moved"
        text = f"a new placement: {options.out}, with {len(samples)} samples since {since}"
        return session.with_message(text)
    if session.samples:
        session = session.with_message(f"continues a recording of {len(session.live)} samples")
    return session


@contextmanager
def page_of(options: RecordOptions) -> "Generator[PageProcess | None, None, None]":
    """Serve the page, if it is asked for, for all placements of a run."""
    if not options.page:
        yield None
        return
    from .page import PageProcess

    with closing(PageProcess(options, options.page_host)) as page:
        yield page


def announced(
    session: Session, options: RecordOptions, remark: str, page: "PageProcess | None"
) -> Session:
    """Return a session that tells what the driver remarked, and where its page is."""
    if remark:
        session = session.with_message(remark, alarm=True)
    if page is None:
        return session
    session = session.with_message(f"page: {page.url}")
    if options.page_host not in LOCAL_HOSTS:
        warning = "whoever knows this address can watch, from anywhere in the network"
        session = session.with_message(warning, alarm=True)
    return session


def recorded_beside(out: Path, robot: robots.Robot) -> tuple[recorder.Placement, ...]:
    """Return the earlier placements in the same folder, recorded with this model, oldest first.

    Those before joints read otherwise are left out: they tell nothing of the readings now.
    """
    rows: list[tuple[float, recorder.Placement, bool]] = []
    for file in out.parent.glob(f"*/{recorder.SAMPLES}"):
        folder = file.parent
        with suppress(recorder.RecordingError):
            metadata = recorder.read_metadata(folder / recorder.METADATA)
            if metadata.get("model_sha256") == robot.sha256:
                placement = recorder.read_placement(folder).for_joints(robot.joint_names)
                changed = metadata.get(recorder.READINGS_CHANGED) is True
                rows.append((placement.samples[0].time or 0.0, placement, changed))
    rows.sort(key=lambda row: row[0])
    stored = recorder.read_metadata(out / recorder.METADATA)
    if stored.get(recorder.READINGS_CHANGED) is True:
        return ()
    placements = list[recorder.Placement]()
    for _, placement, changed in rows:
        placements = [] if changed else placements
        if placement.files[0].parent.resolve() != out.resolve():
            placements.append(placement)
    return tuple(placements)


def summary_of(recording: Recording, session: Session, distance: float | None) -> tuple[str, ...]:
    """Return the recording that is continued, in lines; none at a new placement."""
    if not recording.content.samples:
        return ()
    counts = ", ".join(f"{count} in socket {k}" for k, count in enumerate(session.counts))
    last = session.samples[-1].time
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(last)) if last else "at an unknown time"
    distance_text = "at an unknown distance" if distance is None else f"{1e3 * distance:g} mm apart"
    return (
        f"Continues {counts}; the last {when}; in {recording.folder}",
        f"Sockets {distance_text}. The ball was last in socket {session.socket}.",
        "Is the base where it was?",
    )


def keys_of(options: RecordOptions, stack: ExitStack) -> tuple[Keyboard | None, Script | None]:
    """Return the keyboard where there is a terminal, and the script where there is one."""
    keyboard = None
    if has_keyboard() and sys.platform == "win32":
        import msvcrt

        keyboard = ConsoleKeyboard(msvcrt)
    elif has_keyboard():
        keyboard = Keyboard()
    if options.keys is not None:
        try:
            file = stack.enter_context(options.keys.open("rb"))
        except OSError as error:
            raise calibration.UsageError(f"--keys {options.keys}: {error.strerror}") from None
        return keyboard, Script(file.fileno(), str(options.keys))
    if keyboard:
        return keyboard, None
    if options.auto:
        raise calibration.UsageError("--auto needs a terminal, for the keys between two sockets")
    if options.goal_mm is not None or options.turn is not None:
        raise calibration.UsageError("--goal-mm and --turn need a terminal, where the guide is")
    if sys.stdin is None:  # pyright: ignore[reportUnnecessaryComparison]
        raise calibration.UsageError(
            "standard input is closed; run it in a terminal, or use --keys FILE"
        )
    return None, Script(sys.stdin.fileno())


def connect(text: str, robot: robots.Robot, hand: FollowingHand | None = None) -> Reconnecting:
    """Open ``NAME[:ADDRESS]``, or a hand's arm, as a driver that connects again by itself."""
    name, _, address = text.partition(":")
    if hand:
        connection = hand.connection
    elif name == "mock" and "fault=" in address:
        connection = practice_driver(address, robot)
    else:
        connection = partial(open_driver, name, address, robot.joint_names)
    return Reconnecting(connection, joint_names=robot.joint_names)


def open_recording(options: RecordOptions, metadata: recorder.Metadata, still: float) -> Recording:
    """Open the placement's files, with the notes on this session."""
    notes = {name: getattr(options, name) for name in NOTES}
    session = {"driver": options.driver, "window": options.window, "still": still}
    session |= {name: value for name, value in notes.items() if value is not None}
    return Recording(options.out, replace(metadata, session=session))

"""Start of a session: anew, as an earlier one left it, or with samples of a base that moved."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ... import recorder
from ...recorder.session import Recording, Session
from ...recorder.stream import JointLimits
from ...solver.robot import Robot
from ..cli import DISTANCES, Terminal
from .checks import similar_models
from .options import SettledOptions


@dataclass(frozen=True)
class Before:
    """All that was recorded with this arm before, in the same run."""

    moved: tuple[recorder.Sample, ...] = ()
    """Samples since the base moved."""
    placements: tuple[recorder.Placement, ...] = ()
    """In the order of recording."""


def with_distance(options: SettledOptions, terminal: Terminal) -> SettledOptions:
    """Return options with the distance that the operator types, where none is stated."""
    if options.stated or options.sockets < 2:
        return options
    while not options.scripted:
        terminal.say(
            "How far apart are the sockets' centres? In mm, by a caliper; the printed base has 100."
        )
        try:
            typed = input("mm, or Enter for not yet measured: ").replace("mm", "").strip()
        except EOFError:
            break
        if not typed:
            break
        try:
            number = float(typed.replace(",", "."))
        except ValueError:
            number = math.nan
        metres = number if number < 1 else number / 1e3
        if DISTANCES[0] <= metres <= DISTANCES[1]:
            terminal.say(f"The sockets are {1e3 * metres:g} mm apart.")
            return replace(options, distance=metres, measured=True, stated=True)
        terminal.say(f"{typed!r} is no distance in millimetres, for example 100.08")
    return options


def first_session(
    options: SettledOptions,
    robot: Robot,
    joints: tuple[JointLimits, ...],
    recording: Recording,
    moved: Sequence[recorder.Sample],
) -> Session:
    """Return the session as an earlier start left it, with samples of a base that moved."""
    content = recording.content
    first = len(content.samples) + 1
    moved = [replace(sample, number=i) for i, sample in enumerate(moved, first)]
    for sample in moved:
        recording.capture(sample)
    socket = moved[-1].socket if moved else recording.socket
    session = Session(
        joints,
        sockets=options.sockets,
        target=options.target,
        socket=min(socket, options.sockets - 1),
        samples=(*content.samples, *moved),
        withdrawn=content.withdrawn,
        similar_models=similar_models(robot),
    )
    for remark in recording.remarks:
        session = session.with_message(remark, alarm=True)
    if moved:
        text = f"a new placement: {options.out}, with {len(moved)} samples since the base moved"
        return session.with_message(text)
    if session.samples:
        session = session.with_message(f"continues a recording of {len(session.live)} samples")
    return session


def recorded_beside(out: Path, robot: Robot) -> tuple[recorder.Placement, ...]:
    """Return the other placements beside one that were recorded with a model, the oldest first."""
    found: list[recorder.Placement] = []
    for file in out.parent.glob(f"*/{recorder.SAMPLES}"):
        same = file.parent / recorder.METADATA
        if file.parent.resolve() == out.resolve() or not same.is_file():
            continue
        try:
            if recorder.read_metadata(same).get("model_sha256") == robot.sha256:
                found.append(recorder.read_placement(file.parent).for_joints(robot.joint_names))
        except recorder.RecordingError:
            continue
    return tuple(sorted(found, key=lambda placement: placement.samples[0].time or 0.0))


def with_address(session: Session, url: str, host: str) -> Session:
    """Return the session with messages on the page's address."""
    session = session.with_message(f"page: {url}")
    if host in ("127.0.0.1", "localhost", "::1"):
        return session
    warning = "whoever knows this address can watch, from anywhere in the network"
    return session.with_message(warning, alarm=True)


def resume_summary_of(
    recording: Recording, session: Session, options: SettledOptions
) -> tuple[str, ...]:
    """Return the recording that is continued, in lines; none at a new placement."""
    if not recording.content.samples:
        return ()
    counts = ", ".join(f"{count} in socket {k}" for k, count in enumerate(session.counts))
    last = session.samples[-1].time
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(last)) if last else "at an unknown time"
    apart = f"{1e3 * options.distance:g} mm apart" if options.stated else "at an unknown distance"
    return (
        f"Continues {counts}; the last {when}; in {options.out}",
        f"Sockets {apart}. The ball was last in socket {session.socket}.",
        "Is the base where it was?",
    )

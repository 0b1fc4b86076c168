"""Options of a recording session, and the metadata of its placement."""

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from ...recorder import METADATA, SOCKETS, Metadata, add_reading, read_keys, read_metadata
from ...recorder.session import TARGET
from ...recorder.stream import STILL, WINDOW, JointLimits
from ...solver.calibration import SolveOptions
from ...solver.robot import Robot
from ..cli import DISTANCES, SPREADS, WINDOWS, RobotOptions, Terminal, option, part


def has_keyboard() -> bool:
    """Return whether standard input is a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()  # pyright: ignore[reportUnnecessaryComparison]


POSES = 10
"""Poses of a quick session."""
HELD = 6
"""Samples in each socket for a session that tests a calibration."""


class RecordOptions(RobotOptions):
    """Options of ``mukca record``."""

    driver: str
    out: Path
    robot_name: str | None = None
    distance: float | None = option(between=DISTANCES)
    sockets: int | None = option(between=(1, 10), usual=SOCKETS, unless="quick")
    target: int | None = option(between=(1, 10_000), usual=TARGET)
    window: float = option(WINDOW, between=WINDOWS)
    still: float | None = option(between=SPREADS, usual=STILL)
    keys: Path | None = None
    keep_stream: bool = False
    auto: bool = False
    key: Sequence[str] = option((), repeated=True)
    sound: Literal["bell", "off"] = "bell"
    goal_mm: float | None = option(between=(1e-3, 1e3), unless="calibration no_guide quick keys")
    turn: float | None = option(between=(30, 360), unless="no_guide quick keys")
    page: bool = False
    page_host: str = option("127.0.0.1", needs="page")
    no_guide: bool = False
    quick: bool = False
    calibration: Path | None = option(usual=HELD)
    load: SolveOptions = part(
        SolveOptions, "payload gravity", "load, for noticing a hand on the arm"
    )
    operator: str | None = None
    serial_number: str | None = None
    warm_up: float | None = option(between=(0, 1e6))
    temperature: float | None = option(between=(-100, 200))
    notes: str | None = None

    @property
    def scripted(self) -> bool:
        """True where a script presses the keys."""
        return self.keys is not None or not has_keyboard()

    @property
    def samples(self) -> int:
        """Samples to take in each socket."""
        default = POSES if self.quick else HELD if self.calibration else TARGET
        return self.target or default

    def metadata(self, robot: Robot) -> Metadata:
        """Return the placement's metadata by the options and the recording that is continued."""
        file = self.out / METADATA
        sockets: object = 1 if self.quick else self.sockets
        if sockets is None:
            sockets = read_metadata(file).get("sockets")
        keys = read_keys(file)
        measured = keys.distance is not None and not keys.distance_assumed
        return Metadata(
            robot=robot.name,
            joints=robot.joint_names,
            units=tuple(joint.unit for joint in joints_of(robot)),
            distance=self.distance or keys.distance,
            measured=self.distance is not None or measured,
            sockets=sockets if isinstance(sockets, int) and 1 <= sockets <= 10 else SOCKETS,
            model_sha256=robot.sha256,
            robot_name=self.robot_name or "",
        )


def joints_of(robot: Robot) -> tuple[JointLimits, ...]:
    """Return the limits of the chain's actuated joints."""
    return tuple(
        JointLimits(joint.name, joint.lower, joint.upper, prismatic=joint.type == "prismatic")
        for joint in robot.actuated
    )


def with_distance(metadata: Metadata, terminal: Terminal) -> Metadata:
    """Return metadata with the distance that the operator types."""
    question = "How far apart are the sockets' centres? In mm, by a caliper; the printed base has"
    distance = _typed_distance(f"{question} 100.", "not yet measured", terminal)
    return metadata if distance is None else replace(metadata, distance=distance, measured=True)


def with_second_reading(metadata: Metadata, folder: Path, terminal: Terminal) -> Metadata:
    """Return metadata with a second reading that the operator types, which the recording keeps."""
    if metadata.distance is None or len(read_keys(folder / METADATA).readings) > 1:
        return metadata
    question = "Measure the sockets' distance once more: solve believes two readings that agree."
    distance = _typed_distance(question, "no second reading", terminal)
    if distance is None:
        return metadata
    add_reading(folder, distance)
    return replace(metadata, distance=distance)


def _typed_distance(question: str, advice: str, terminal: Terminal) -> float | None:
    """Return a distance that the operator types [m]; None for an empty answer."""
    while True:
        terminal.say(question)
        try:
            answer = input(f"mm, or Enter for {advice}: ").replace("mm", "").strip()
        except EOFError:
            answer = ""
        if not answer:
            return None
        try:
            number = float(answer.replace(",", "."))
        except ValueError:
            number = math.nan
        metres = number if number < 1 else number / 1e3
        if DISTANCES[0] <= metres <= DISTANCES[1]:
            terminal.say(f"The sockets are {1e3 * metres:g} mm apart.")
            return metres
        terminal.say(f"{answer!r} is no distance in millimetres, for example 100.08")

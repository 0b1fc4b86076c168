"""Options of a recording session, and those of one in which nothing is left open."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ...recorder import DEFAULT_DISTANCE, METADATA, SOCKETS, read_keys, read_metadata
from ...recorder.session import TARGET
from ...recorder.stream import STILL, WINDOW
from ...solver.calibration import SolveOptions
from ..cli import DISTANCES, SPREADS, WINDOWS, RobotOptions, option, part


def has_keyboard() -> bool:
    """Return whether standard input is a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()  # pyright: ignore[reportUnnecessaryComparison]


POSES = 10
"""Poses of a quick session."""
HELD = 6
"""Samples in each socket that tell what changed since a calibration."""


@dataclass(frozen=True, kw_only=True)
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

    def settled(self) -> "SettledOptions":
        """Return the options with defaults, of the recording that is continued if there is one."""
        file = self.out / METADATA
        sockets: object = 1 if self.quick else self.sockets
        if sockets is None:
            sockets = read_metadata(file).get("sockets")
        keys = read_keys(file)
        known = keys.distance is not None and not keys.distance_assumed
        usual = POSES if self.quick else HELD if self.calibration else TARGET
        given: dict[str, Any] = {
            **vars(self),
            "distance": self.distance or keys.distance or DEFAULT_DISTANCE,
            "measured": self.distance is not None or known,
            "stated": self.distance is not None or keys.distance is not None,
            "sockets": sockets if isinstance(sockets, int) and 1 <= sockets <= 10 else SOCKETS,
            "target": self.target or usual,
            "no_guide": self.no_guide or self.quick,
        }
        return SettledOptions(**given)


@dataclass(frozen=True, kw_only=True)
class SettledOptions(RecordOptions):
    """Options of a session that knows its distance [m], its sockets, and its samples a socket."""

    distance: float = DEFAULT_DISTANCE
    measured: bool = False
    """True where somebody measured the distance."""
    stated: bool = False
    """False where the distance is nothing but the paper's: neither typed nor in the files."""
    sockets: int = SOCKETS
    target: int = TARGET

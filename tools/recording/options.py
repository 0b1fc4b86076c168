"""Options of a recording session, and those of one in which nothing is left open."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from ...recorder import DEFAULT_DISTANCE, METADATA, SOCKETS, read_keys, read_metadata
from ...recorder.session import TARGET
from ...recorder.stream import STILL, WINDOW
from ...solver.calibration import SolveOptions
from ..cli import DISTANCES, SPREADS, WINDOWS, RobotOptions, option, part

POSES = 10
"""Poses of a quick session."""
HELD = 6
"""Samples in each socket that tell what changed since a calibration."""

_recording = partial(option, group="recording")
_hands = partial(option, group="hands and ears")
_guide = partial(option, group="guide")
_quick = partial(option, group="in two minutes")
_notes = partial(option, group="notes, kept with the recording")


@dataclass(frozen=True, kw_only=True)
class RecordOptions(RobotOptions):
    """Options of ``mukca record``."""

    driver: str = _recording("see mukca drivers", "NAME[:ADDRESS]", ...)
    out: Path = _recording("continued if it exists", "DIR/PLACEMENT", ...)
    robot_name: str | None = _recording(
        "which of several robots it is, as solve --robot NAME=R has it", "NAME"
    )
    distance: float | None = _recording(
        "between the centres of sockets 0 and 1, in metres, as measured with a caliper "
        "(default: what is continued, or asked for)",
        "M",
        between=DISTANCES,
    )
    sockets: int | None = _recording(f"1 to 10 (default: {SOCKETS})", "N", between=(1, 10))
    target: int | None = _recording(
        f"samples for each socket (default: {TARGET})", "N", between=(1, 10_000)
    )
    window: float = _recording("seconds that a capture averages", "S", WINDOW, between=WINDOWS)
    still: float | None = _recording(
        "largest standard deviation over the window of an arm that is still "
        f"(default: {STILL}, or the step of its encoders)",
        "RAD",
        between=SPREADS,
    )
    keys: Path | None = _recording("read keys from a script", "FILE")
    keep_stream: bool = _recording(
        "keep every state in a compact file beside the samples, for mukca extract to look at again",
        default=False,
    )
    auto: bool = _hands(
        "capture without a key wherever the arm comes to rest at a new, plausible pose; a key at "
        "each change of socket",
        default=False,
    )
    key: Sequence[str] = _hands(
        "let keys do something, as in capture=Enter,PageDown for a foot pedal or a presenter: "
        "capture, undo, redo, delete, relabel, next, finish, help",
        "ACTION=KEY,...",
        (),
        repeated=True,
    )
    sound: Literal["bell", "off"] = _hands(
        "the terminal's bell: once captured, twice refused, three times a socket done",
        default="bell",
    )
    goal_mm: float | None = _guide(
        "what the predicted error of distances in the workspace should come to (default: what "
        "mukca solve asks)",
        "MM",
        between=(1e-3, 1e3),
    )
    turn: float | None = _guide(
        "lead no joint farther than this from where the session began, for cables",
        "DEG",
        between=(30, 360),
    )
    page: bool = _guide(
        "show the same on a page, read-only, for a tablet beside the arm; its address is on the "
        "screen",
        default=False,
    )
    page_host: str = _guide(
        "where the page is served; 0.0.0.0 lets the whole network see it (default: this computer "
        "alone)",
        "HOST",
        "127.0.0.1",
    )
    no_guide: bool = _guide("no fit while recording", default=False)
    quick: bool = _quick(
        "one socket, ten poses: how far off is this arm, and is it worth calibrating?",
        default=False,
    )
    calibration: Path | None = _quick(
        f"does this calibration still hold? Exit status 1 if not. Without --quick: {HELD} samples "
        "in each of two sockets, led to poses that tell the joints' zeros best, for mukca rezero",
        "FILE",
    )
    load: SolveOptions = part(
        SolveOptions, "payload", "gravity", group="load, for noticing a hand on the arm"
    )
    operator: str | None = _notes("", "NAME")
    serial_number: str | None = _notes("of the arm", "TEXT")
    warm_up: float | None = _notes("minutes since power-on", "MIN", between=(0, 1e6))
    temperature: float | None = _notes("degrees Celsius", "C", between=(-100, 200))
    notes: str | None = _notes("", "TEXT")

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

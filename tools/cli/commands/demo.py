"""``mukca demo``: the whole job on a simulated arm, by the commands that a user would type."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from .... import recorder
from ....solver.results import OutputError, refuse_existing
from .. import Terminal, option
from .main import build_parser, run_verb

NEXT = """
Next, with an arm of your own (`mukca drivers` lists which): print the base and the ball, measure
the distance of the sockets' centres in metres, record at two places or more, and solve as above.
  mukca print-parts --out parts
  mukca record --robot panda --driver franka:172.16.0.2 --distance 0.1001 --out recordings/front"""
DISTANCE = 0.1
"""Between the sockets of the printed base [m]."""
SPEED = 10
"""Speed of the hand against a person's, and of the recorder with it."""
KEYS = "keys.txt"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of ``mukca demo``."""

    out: Path = option("where to write", "DIR", Path("demo"))
    force: bool = option("overwrite results in DIR", default=False)


def run(options: Options, terminal: Terminal) -> int:
    """Record three placements of the demo arm, calibrate on one, validate on the others."""
    from ...simulation import demo_bases, simulate_hand

    out = options.out
    refuse_existing(out, force=options.force)
    recordings, calibrated = out / "recordings", out / "calibrated"
    names = [base.name for base in demo_bases(DISTANCE)]
    for name in names:
        _remove_simulated(recordings / name)
    simulate_hand(out / "hand", out / KEYS, DISTANCE)
    brief = Terminal(json=terminal.json, brief=True)
    for name in names:
        driver = f"mock:{out / 'hand' / name}?rate=100&speed={SPEED}&hold=0.65&move=0.6"
        words = ["record", "--robot", "panda", "--driver", driver, "--distance", str(DISTANCE)]
        words += ["--out", str(recordings / name), "--keys", str(out / KEYS)]
        status = _run(words, brief)
        if status != 0:
            return status
    front, *held_out = (str(recordings / name) for name in names)
    words = ["solve", front, "--robot", "panda", "--test", *held_out, "--out", str(calibrated)]
    status = _run([*words, "--force"] if options.force else words, terminal)
    if status == 0:
        document = str(calibrated / "calibration.json")
        status = _run(["validate", document, front, *held_out], terminal)
        terminal.say(f"Recordings:      {', '.join((front, *held_out))}")
        terminal.say(f"Calibrated URDF: {calibrated / 'calibrated.urdf'}")
        terminal.say(f"Report:          {calibrated / 'report.html'}")
        terminal.say(NEXT)
    return status


def _remove_simulated(folder: Path) -> None:
    """Remove an earlier demo's recording, which a recorder would else continue."""
    if (folder / recorder.SAMPLES).exists():
        sessions: Any = recorder.read_metadata(folder / recorder.METADATA).get("sessions")
        rows = cast("list[object]", sessions) if isinstance(sessions, list) else []
        drivers = [str(cast("Any", row).get("driver")) for row in rows if isinstance(row, dict)]
        if not rows or len([one for one in drivers if one.startswith("mock:")]) < len(rows):
            raise OutputError(f"{folder}: holds a recording of a real arm; choose another --out")
    for name in (recorder.SAMPLES, recorder.METADATA):
        (folder / name).unlink(missing_ok=True)


def _run(words: list[str], terminal: Terminal) -> int:
    """Run another verb as a user would, and show what was typed."""
    terminal.say(f"\n$ {shlex.join(['mukca', *words])}\n")
    return run_verb(build_parser(words[0]).parse_args(words), terminal)

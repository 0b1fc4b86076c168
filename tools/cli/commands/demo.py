"""``mukca demo``: the whole job on a simulated arm, by the commands that a user would type."""

import argparse
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ....solver.results import OutputError, refuse_existing, write_files
from .. import Command, Terminal
from . import record, solve, validate

if TYPE_CHECKING:
    from ....solver.robot import Robot
    from ...simulation import Base

EXAMPLE = """example:
  mukca demo --out demo

The demo arm is a Panda whose true joint origins differ from its URDF by some 5 mm and 12 mrad."""

DEMO_SEED = 2920
"""Such a draw is off by 20 mm at the median; with this seed it is 7 to 9 mm, as real arms are."""
ORIGIN_DEVIATION = (5e-3, 12e-3)
"""Standard deviation of the true origins from the nominal ones [m, rad]."""
NEXT = """
Next, with an arm of your own (`mukca drivers` lists which): print the base and the ball, measure
the distance of the sockets' centres in metres, record at two places or more, and solve as above.
  mukca print-parts --out parts
  mukca record --robot panda --driver franka:172.16.0.2 --distance 0.0501 --out recordings/front"""
SPEED = 10
"""The hand is so much faster than a person's, and the recorder with it."""
KEYS = "keys.txt"
SEAT_NOISE = 5e-5
"""How well the ball sits, standard deviation per axis [m]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="where to")
    parser.add_argument("--force", action="store_true", help="overwrite results in DIR")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Record three placements of the demo arm, calibrate on one, validate on the others."""
    out: Path = arguments.out
    refuse_existing(out, force=arguments.force)
    recordings, calibrated = out / "recordings", out / "calibrated"
    _remove_simulated(recordings)
    simulate_hand(out / "hand", out / KEYS)
    brief = Terminal(json=terminal.json, brief=True)
    front, *held_out = (str(recordings / base.name) for base in demo_bases())
    for folder in (front, *held_out):
        status = _run(record, record_words(Path(folder), out), brief)
        if status != 0:
            return status
    words = ["solve", front, "--robot", "panda", "--test", *held_out, "--out", str(calibrated)]
    status = _run(solve, [*words, "--force"] if arguments.force else words, terminal)
    if status == 0:
        document = str(calibrated / "calibration.json")
        status = _run(validate, ["validate", document, front, *held_out], terminal)
        terminal.say(f"Recordings:      {', '.join((front, *held_out))}")
        terminal.say(f"Calibrated URDF: {calibrated / 'calibrated.urdf'}")
        terminal.say(f"Report:          {calibrated / 'report.html'}")
        terminal.say(NEXT)
    return status


def record_words(folder: Path, out: Path) -> list[str]:
    """Return the command that records a placement while the mock moves the arm, sped up."""
    hand = out / "hand" / folder.name
    driver = f"mock:{hand}?rate=100&speed={SPEED}&hold=0.65&move=0.6"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(folder)]
    return [*words, "--keys", str(out / KEYS)]


def demo_arm(seed: int = DEMO_SEED, *, keep_size: bool = True) -> "tuple[Robot, Robot]":
    """Return the nominal Panda, and the demo arm as it truly is; or another, drawn like it.

    Args:
        seed: Of the draw.
        keep_size: Whether it is as large as the nominal arm, as real arms are.
    """
    import numpy as np

    from ....solver.robot import load_robot
    from ...simulation import perturb

    nominal = load_robot("panda")
    return nominal, perturb(
        nominal, np.random.default_rng(seed), *ORIGIN_DEVIATION, keep_size=keep_size
    )


def demo_bases() -> "list[Base]":
    """Return where the socket base stands: in front of the arm, and to its left and right."""
    import numpy as np

    from ...simulation import Base

    along_y = np.array([0.0, 1.0, 0.0])
    places = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}
    return [Base(name, np.array(place), along_y) for name, place in places.items()]


def simulate_hand(folder: Path, keys: Path) -> None:
    """Write where a hand leads the demo arm at each place, and the keys that it presses there."""
    import numpy as np

    from ....recorder import sample_files
    from ....solver.robot import gravity_torques
    from ...simulation import record

    _, arm = demo_arm()
    generator = np.random.default_rng(0)
    for base in demo_bases():
        led = record(arm, base, generator, noise=SEAT_NOISE)
        efforts = gravity_torques(arm, led.positions).tolist()
        pairs = zip(led.samples, efforts, strict=True)
        held = tuple(replace(sample, effort=tuple(effort)) for sample, effort in pairs)
        write_files(folder / base.name, sample_files(replace(led, samples=held)))
    write_files(keys.parent, {keys.name: b"a*30  s  a*30  q\n"})


def _remove_simulated(recordings: Path) -> None:
    """Remove an earlier demo's recordings, which a recorder would else continue.

    Raises:
        OutputError: One of them is of another arm.
    """
    from ....recorder import METADATA, SAMPLES

    for base in demo_bases():
        folder = recordings / base.name
        if (folder / SAMPLES).exists() and not _is_simulated(folder / METADATA):
            raise OutputError(f"{folder}: holds a recording of a real arm; choose another --out")
        for name in (SAMPLES, METADATA):
            (folder / name).unlink(missing_ok=True)


def _is_simulated(metadata: Path) -> bool:
    """Tell whether a recording was made with the mock alone."""
    from ....recorder import read_metadata

    sessions: Any = read_metadata(metadata).get("sessions")
    if not isinstance(sessions, list) or not sessions:
        return False
    rows = cast("list[dict[str, Any]]", sessions)
    return all(isinstance(row, dict) and str(row.get("driver")).startswith("mock:") for row in rows)  # pyright: ignore[reportUnnecessaryIsInstance]


def _run(command: Command, words: list[str], terminal: Terminal) -> int:
    """Run another verb as a user would, and show what was typed."""
    terminal.say(f"\n$ {shlex.join(['mukca', *words])}\n")
    parser = argparse.ArgumentParser(prog=f"mukca {words[0]}")
    command.add_arguments(parser)
    return command.run(parser.parse_args(words[1:]), terminal)

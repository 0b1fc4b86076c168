"""``mukca demo``: the whole job on a simulated arm, by the commands that a user would type."""

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from ..files import refuse_existing
from ..terminal import Terminal
from . import Command, solve, validate

if TYPE_CHECKING:
    from ...solver.urdf import Chain
    from ..simulate import Base

EXAMPLE = """example:
  mukca demo --out demo

The demo arm is a Panda whose true joint origins differ from its URDF by some 5 mm and 12 mrad."""

DEMO_SEED = 2920
"""Such a draw is off by 20 mm at the median; with this seed it is 7 to 9 mm, as real arms are."""
ORIGIN_DEVIATION = (5e-3, 12e-3)
"""Standard deviation of the true origins from the nominal ones [m, rad]."""
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
    terminal.say("Recording the demo arm: 2 x 30 configurations at each of three placements")
    write_recordings(out / "recordings")
    front, calibrated = out / "recordings/front", out / "calibrated"
    held_out = [str(out / "recordings/left"), str(out / "recordings/right")]
    words = ["solve", str(front), "--robot", "panda", "--test", *held_out, "--out", str(calibrated)]
    status = _run(solve, [*words, "--force"] if arguments.force else words, terminal)
    if status == 0:
        document = str(calibrated / "calibration.json")
        status = _run(validate, ["validate", document, *held_out], terminal)
    return status


def demo_arm(seed: int = DEMO_SEED) -> "tuple[Chain, Chain]":
    """Return the nominal Panda, and the demo arm as it truly is; or another, drawn like it."""
    import numpy as np

    from ...solver.urdf import load_chain
    from ..simulate import perturb

    nominal = load_chain("panda")
    return nominal, perturb(nominal, np.random.default_rng(seed), *ORIGIN_DEVIATION)


def demo_bases() -> "list[Base]":
    """Return where the socket base stands: in front of the arm, and to its left and right."""
    import numpy as np

    from ..simulate import Base

    along_y = np.array([0.0, 1.0, 0.0])
    places = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}
    return [Base(name, np.array(place), along_y) for name, place in places.items()]


def write_recordings(folder: Path) -> None:
    """Write a recording of the demo arm at each place into a folder of its own."""
    import numpy as np

    from ..simulate import record, write_holes

    _, arm = demo_arm()
    generator = np.random.default_rng(0)
    for base in demo_bases():
        write_holes(record(arm, base, generator, noise=SEAT_NOISE), folder / base.name)


def _run(command: Command, words: list[str], terminal: Terminal) -> int:
    """Run another verb as a user would, and show what was typed."""
    terminal.say(f"\n$ {shlex.join(['mukca', *words])}\n")
    parser = argparse.ArgumentParser(prog=f"mukca {words[0]}")
    command.add_arguments(parser)
    return command.run(parser.parse_args(words[1:]), terminal)

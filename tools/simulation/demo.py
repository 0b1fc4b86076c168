"""The demo, and practice without an arm: its arm, its socket bases, and the hand that leads it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...recorder import DEFAULT_DISTANCE, sample_files
from ...solver.identification.robot import Robot, gravity_moments, load_robot
from ...solver.results import write_files
from .recordings import Base, record
from .simulated_arms import perturb

DEMO_SEED = 2920
"""Such a draw is off by 20 mm at the median; with this seed it is 7 to 9 mm, as real arms are."""
ORIGIN_DEVIATION = (5e-3, 12e-3)
"""Standard deviation of the true origins from the nominal ones [m, rad]."""
TURN = 6
"""Samples in a socket before it is the other's turn."""
TURNS = 5
"""Of each socket."""
SEAT_NOISE = 5e-5
"""Standard deviation of the ball's seat, per axis [m]."""
PLACES = {
    "front": (0.5, 0.0, 0.1),
    "left": (0.35, 0.4, 0.1),
    "right": (0.35, -0.4, 0.1),
}
"""Of the socket base: in front of the arm, and to its left and right [m]."""


def demo_arm(seed: int = DEMO_SEED, *, keep_size: bool = True) -> tuple[Robot, Robot]:
    """Return the nominal Panda and the demo arm as it truly is, of nominal size; or one like it."""
    nominal = load_robot("panda")
    generator = np.random.default_rng(seed)
    arm = perturb(nominal, generator, *ORIGIN_DEVIATION, keep_size=keep_size)
    return nominal, arm


def demo_bases(distance: float = DEFAULT_DISTANCE) -> list[Base]:
    """Return the socket base at each of its places, its sockets so far apart along y [m]."""
    along_y = np.array([0.0, 1.0, 0.0])
    return [
        Base(name, np.array(place), along_y, distance) for name, place in PLACES.items()
    ]


def simulate_hand(folder: Path, keys: Path, distance: float) -> None:
    """Write the poses that a hand leads the demo arm to at each base, and the keys pressed.

    The sockets, so far apart [m], take turns by sixes, as ``mukca record`` asks for.
    """
    _, arm = demo_arm()
    generator = np.random.default_rng(0)
    contents: dict[str, bytes] = {}
    for base in demo_bases(distance):
        led = record(
            arm,
            base,
            generator,
            samples=TURN * TURNS,
            noise=SEAT_NOISE,
        )
        # With the torques that gravity exerts on each joint [N m].
        torques = gravity_moments(arm, led.positions)[:, : len(arm.actuated)]
        rows = zip(led.samples, torques.tolist(), strict=True)
        samples = [replace(sample, effort=tuple(row)) for sample, row in rows]
        # The sockets take turns.
        turns = np.arange(len(samples)).reshape(2, TURNS, TURN).swapaxes(0, 1)
        ordered = tuple(samples[i] for i in turns.ravel())
        files = sample_files(replace(led, samples=ordered))
        contents |= {f"{base.name}/{file}": text for file, text in files.items()}
    script = b"a*6 s  " * (2 * TURNS - 1) + b"a*6 q\n"
    write_files(folder, contents)
    write_files(keys.parent, {keys.name: script})

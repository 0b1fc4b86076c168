"""Recordings of simulated arms: at bases that stand where a test says, or anywhere in reach."""

from dataclasses import replace

import numpy as np
from altered import moved

from mukca import load_robot
from mukca.recorder import read_keys, set_distance, write_holes
from mukca.solver.identification.effects import EXTENSIONS
from mukca.solver.identification.model import Deflection
from mukca.tools.simulation import Base, Imperfection, perturb, reachable_bases, record

PLACES = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}
"""Where the bases of a session at a Panda stand [m]."""
RIGID = {"without": tuple(EXTENSIONS)}
"""Options of a calibration that tries no effect, which takes a fraction of the time."""
BESIDE = np.array([0.0, 1.0, 0.0])
"""From socket 0 to socket 1 of those bases."""


def true_arm(robot, generator, translation=2e-3, turn=5e-3):
    """Draw an arm whose joints are off its model, by some translation [m] and turn [rad]."""
    return perturb(robot, generator, translation, turn)


def recorded_at(arm, place, seed=1, name="front", samples=20, distance=0.05, **how):
    """Record an arm at a base by its centre [m], so many samples in each socket, 0.1 mm noisy."""
    base = Base(name, np.array(place), BESIDE, distance)
    how = how or {"noise": 1e-4}
    return record(arm, base, np.random.default_rng(seed), samples=samples, **how)


def recorded_in_reach(arm, generator, count, distance=0.05, **how):
    """Record an arm at so many bases that it reaches."""
    bases = reachable_bases(arm, generator, count, distance)
    return [record(arm, base, generator, **how) for base in bases]


def recorded_with_loads(robot, masses, compliance, samples):
    """Record an arm whose joints bend [rad/(N m)], with a mass at the ball for each base [kg]."""
    generator = np.random.default_rng(3)
    arm = true_arm(robot, generator, 1e-3, 3e-3)
    bent = Deflection(("compliance",), (np.full(len(robot.actuated), compliance),))
    how, bases = Imperfection(5e-5, bent), reachable_bases(arm, generator, len(masses))
    arms = [arm.carrying(mass, arm.ball_joint.origin.xyz) for mass in masses]
    pairs = zip(arms, bases, strict=True)
    return [record(a, b, generator, samples=samples, imperfection=how) for a, b in pairs]


def recorded_by_servos(name, seed, count, distance=0.05):
    """Record an arm of servos, whose zeros are off by up to 5 degrees and whose joints have play.

    The robot, and placements of 20 samples in each socket.
    """
    robot, generator = load_robot(name), np.random.default_rng(seed)
    arm = true_arm(robot, generator, 3e-4, 0.0)
    zeros = generator.uniform(-0.087, 0.087, len(robot.actuated))
    play = Imperfection(3e-4, play=0.012, resolution=1.5e-3)
    found = recorded_in_reach(arm, generator, count, distance, samples=20, imperfection=play)
    return robot, [moved(placement, placement.positions - zeros) for placement in found]


def write_sockets(folder, placement):
    """Write a placement as a file of joint positions for each socket, and no distance."""
    write_holes(replace(placement, distance=None), folder)


def readings_in(folder):
    """Return the readings of the sockets' distance that a folder's placement.json has [m]."""
    return read_keys(folder / "placement.json").readings


def write_session(folder, arm):
    """Write three placements of an arm, 12 samples in each socket, whose distance is known."""
    generator = np.random.default_rng(8)
    for name, place in PLACES.items():
        placement = recorded_at(arm, place, generator, name, samples=12, noise=5e-5)
        write_sockets(folder / name, placement)
        set_distance(folder / name, 0.05)

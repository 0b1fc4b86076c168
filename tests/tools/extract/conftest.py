"""A simulated session at a Panda as a stream of joint states, and logs that are made of it."""

from functools import partial

import numpy as np
import pytest

from mukca.drivers.arms import Fault, Motion, SimulatedArm
from mukca.recorder import read_placement

RATE = 40.0
HOLD, MOVE = 0.95, 0.6
PAUSES = (0, 7, 20)
"""Before these samples the arm also rested in the air."""


class Session:
    """What the arm did: rests at known places, moves between, states missing here and there."""

    def __init__(self, folder):
        placement = read_placement(folder)
        rng = np.random.default_rng(4)
        self.places = []
        self.sockets = []
        """The socket of each rest; None for a pause in the air."""
        for i, sample in enumerate(placement.samples):
            if i in PAUSES:
                away = np.array(sample.position) + rng.uniform(0.3, 0.4, 7)
                self.places.append(tuple(away.tolist()))
                self.sockets.append(None)
            self.places.append(sample.position)
            self.sockets.append(sample.socket)
        lost = [f"silent@{(HOLD + MOVE) * k + 0.8}+0.5" for k in range(4, 24, 5)]
        lost += [f"nan@{(HOLD + MOVE) * 8 + 0.1}+0.05", f"zeros@{(HOLD + MOVE) * 9 + 0.05}+0.1"]
        self.hold, self.move = HOLD, MOVE
        motion = Motion(self.places, hold=HOLD, move=MOVE)
        arm = SimulatedArm(
            motion, rate=RATE, noise=2e-5, faults=[Fault.parse(text) for text in lost]
        )
        self.states = [
            arm.state(moment)
            for moment in np.arange(0, motion.duration, 1 / RATE).tolist()
            if not arm.shows("silent", moment)
        ]

    def read_back(self, folder, within=4e-5):
        """Return a placement that holds all samples of the session, and nothing else."""
        placement, rests = read_placement(folder), zip(self.places, self.sockets, strict=True)
        expected = [(q, socket) for q, socket in rests if socket is not None]
        assert placement.sockets.tolist() == [socket for _, socket in expected]
        assert np.abs(placement.positions - [q for q, _ in expected]).max() < within
        return placement


@pytest.fixture(scope="session")
def moves(session):
    return Session(session / "front")


@pytest.fixture
def extract(command):
    """Run `mukca extract`: status, output, error."""
    return partial(command, "extract")

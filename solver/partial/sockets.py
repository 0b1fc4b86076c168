"""Samples of a ball in sockets, as rows of a fit."""

from collections.abc import Sequence

import numpy as np

from ..calibration import UsageError
from ..data import Measurement
from .fit import NoiseBelief, Task
from .prior import SOCKET, ArmPrior
from .rows import Rows

BALL_ELSEWHERE = 0.1
"""Standard deviation of the ball's place where it was put on again [m]."""


def socket_task(
    prior: ArmPrior, data: Sequence[Measurement], stood: str = "", *, ball_moved: bool = False
) -> Task:
    """Return the samples of a ball in sockets, the arm as it was calibrated."""
    if any(m.kind == "points" for m in data):
        raise UsageError("give placements with the ball in sockets, not measured points")
    pairs = [(m.name, socket) for m in data for socket in m.sockets]
    place = {pair: i for i, pair in enumerate(pairs)}
    rows = Rows(
        np.concatenate([m.positions for m in data]),
        np.concatenate([prior.load.torques(prior.robot, m) for m in data]),
        np.repeat(np.arange(len(pairs)), [count for m in data for count in m.counts]),
        tuple(_known_socket(prior, stood, *pair) if stood else str(pair) for pair in pairs),
    )
    distances = [
        (place[m.name, m.sockets[0]], place[m.name, m.sockets[1]], m.distance)
        for m in data
        if m.has_distance
    ]
    free = dict.fromkeys(prior.ball.tolist(), BALL_ELSEWHERE) if ball_moved else {}
    noise = NoiseBelief(prior.noise.space, joint=prior.noise.joint)
    return Task(prior, rows, noise, free, distances)


def _known_socket(prior: ArmPrior, stood: str, placement: str, socket: int) -> str:
    """Return the name of a socket of the calibration, at which a new one still stands."""
    last = SOCKET.format(stood, socket)
    known = [name for name in prior.sockets if name == last or name.endswith(f"/{last}")]
    if len(known) != 1:
        trained = ", ".join(prior.sockets) or "none"
        raise UsageError(
            f"{placement}: socket {socket} does not stand where {stood!r} was calibrated; "
            f"sockets there (PLACEMENT:SOCKET): {trained}"
        )
    return known[0]

"""Which placement should be recorded next? The answer."""

from collections.abc import Sequence

import numpy as np

from ....solver.assessment import (
    Coverage,
    PlacementReport,
    area,
    as_point,
    joined,
    norms,
    short_names,
)
from ....solver.diagnostics import Diagnostic, farthest_place
from ....solver.results import NextPlacement
from .answer_data import placements_with_errors
from .types_answers import NextAnswer

HARDLY_MOVED = float(np.radians(30))
"""A joint that turns less than this in a socket tells little about itself [rad]."""


def next_answer(
    placements: Sequence[PlacementReport],
    coverage: Coverage,
    checks: Sequence[Diagnostic] | None,
    advice: NextPlacement | None,
) -> NextAnswer:
    """Return which placement to train on and to record next, and which joints to turn more.

    Args:
        placements: All of them.
        coverage: How far the joints moved.
        checks: What was found in the recordings.
        advice: What the method itself says of the next placement; None for the place farthest
            from all others.
    """
    positions = np.array([row.position for row in placements])
    trained = np.array([row.role == "train" for row in placements])
    place = as_point(farthest_place(positions))
    joints = hardly_moved(coverage)
    wrong = list(placements_with_errors(placements, checks))
    texts = [f"First mend {joined(wrong)}, see below."] if wrong else []
    train_on: str | None = None
    if advice is not None and advice.text:
        texts.append(advice.text)
    else:
        names = short_names([row.name for row in placements])
        free = ~trained & [name not in wrong for name in names]
        if free.any():
            train_on, words = _train_on(positions, trained, free, names)
            texts.append(words)
        gap = float(norms(positions - place).min())
        held_out = ", to hold out," if trained.all() else ""
        texts.append(
            f"Record a new one{held_out} about {area(place)} as the robot sees it, "
            f"{gap:.2f} m from the nearest so far, or as near to there as your table allows."
        )
    if joints:
        texts.append(
            f"Turn {joined(joints)} more: in some socket trained on, too little to learn from."
        )
    return NextAnswer(text=" ".join(texts), train_on=train_on, place=place, joints=tuple(joints))


def _train_on(
    positions: np.ndarray, trained: np.ndarray, free: np.ndarray, names: list[str]
) -> tuple[str, str]:
    """Return the free placement farthest from all trained on, and why to train on it."""
    gaps = norms(positions[:, None] - positions[trained]).min(axis=1)
    farthest = int(np.argmax(np.where(free, gaps, -1.0)))
    name = names[farthest]
    return name, (
        f"Train on {name} too: it is recorded already, and with {gaps[farthest]:.2f} m the "
        "farthest from what was trained on; the two most distant placements serve best."
    )


def hardly_moved(coverage: Coverage) -> list[str]:
    """Return the joints that hardly turned in some socket that was trained on."""
    trained = [socket for socket in coverage.sockets if socket.role == "train"]
    return [
        joint.name
        for i, joint in enumerate(coverage.joints)
        if joint.unit == "rad"
        and any(socket.high[i] - socket.low[i] < HARDLY_MOVED for socket in trained)
    ]

"""Which placement should be recorded next? The answer."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...solver.checks.inspection import farthest_place
from .answer_data import placements_with_errors
from .words import area, joined, short_names

__all__ = ["HARDLY_MOVED", "hardly_moved", "next_answer"]

Vector = NDArray[np.float64]
HARDLY_MOVED = float(np.radians(30))
"""A joint that turns less than this in a socket tells little about itself [rad]."""


def next_answer(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return which placement to train on and to record next, and which joints to turn more.

    Returns:
        ``text``; ``train_on``, a placement recorded already, or None; ``place``, a point in the
        base frame [m]; ``joints`` that hardly moved.
    """
    positions = np.array([row["position"] for row in figures["placements"]])
    trained = np.array([row["role"] == "train" for row in figures["placements"]])
    names = short_names([row["name"] for row in figures["placements"]])
    place = farthest_place(positions)
    joints = hardly_moved(figures)
    given: str | None = dict(figures.get("next_placement") or {}).get("text")
    wrong = list(placements_with_errors(figures))
    texts = [f"First mend {joined(wrong)}, see below."] if wrong else []
    texts += [given] if given else []
    train_on: str | None = None
    if not given and not trained.all():
        train_on, words = _train_on(positions, trained, names)
        texts.append(words)
    if not given:
        gap = float(np.linalg.norm(positions - place, axis=1).min())
        held_out = ", to hold out," if trained.all() else ""
        texts.append(
            f"Record a new one{held_out} about {area(place.tolist())} as the robot sees it, "
            f"{gap:.2f} m from the nearest so far, or as near to there as your table allows."
        )
    if joints:
        texts.append(
            f"Turn {joined(joints)} more: in some socket trained on, too little to learn from."
        )
    return {
        "text": " ".join(texts),
        "train_on": train_on,
        "place": place.tolist(),
        "joints": joints,
    }


def _train_on(positions: Vector, trained: NDArray[np.bool_], names: list[str]) -> tuple[str, str]:
    """Return the placement farthest from all that were trained on, and why to train on it."""
    gaps = np.linalg.norm(positions[:, None] - positions[trained], axis=2).min(axis=1)
    farthest = int(np.argmax(np.where(trained, -1.0, gaps)))
    name = names[farthest]
    return name, (
        f"Train on {name} too: it is recorded already, and with {gaps[farthest]:.2f} m the "
        "farthest from what was trained on; the two most distant placements serve best."
    )


def hardly_moved(figures: Mapping[str, Any]) -> list[str]:
    """Return the joints that hardly turned in some socket that was trained on."""
    coverage = figures["coverage"]
    trained = [socket for socket in coverage["sockets"] if socket["role"] == "train"]
    return [
        joint["name"]
        for i, joint in enumerate(coverage["joints"])
        if joint["unit"] == "rad"
        and any(socket["high"][i] - socket["low"][i] < HARDLY_MOVED for socket in trained)
    ]

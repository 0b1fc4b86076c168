"""Coverage of the joint ranges by the recordings, in each socket."""

from typing import Literal

import numpy as np

from ..results import Document, Role
from .predictions import Predictions


class JointRange(Document, kw_only=True, frozen=True):
    """A joint and its limits."""

    name: str
    unit: Literal["rad", "m"]
    lower: float | None
    upper: float | None


class SocketCoverage(Document, kw_only=True, frozen=True):
    """Joint positions in one socket [rad, m for prismatic joints]."""

    placement: str
    role: Role
    socket: int
    low: tuple[float, ...]
    """Smallest position of each joint."""
    high: tuple[float, ...]
    positions: tuple[tuple[float, ...], ...]
    """Of the samples, thinned out where there are many; shape (N, joints)."""


class Coverage(Document, kw_only=True, frozen=True):
    """Range of each joint in each socket."""

    joints: tuple[JointRange, ...]
    sockets: tuple[SocketCoverage, ...]


def coverage(predictions: Predictions, most: int) -> Coverage:
    """Return where the joints were in each socket, at most so many samples of each."""
    return Coverage(
        joints=tuple(
            JointRange(
                name=joint.name,
                unit="m" if joint.type == "prismatic" else "rad",
                lower=joint.lower if np.isfinite(joint.lower) else None,
                upper=joint.upper if np.isfinite(joint.upper) else None,
            )
            for joint in predictions.robot.actuated
        ),
        sockets=tuple(
            SocketCoverage(
                placement=placement.name,
                role=placement.role,
                socket=k,
                low=tuple(rows.min(axis=0).tolist()),
                high=tuple(rows.max(axis=0).tolist()),
                positions=tuple(map(tuple, np.round(rows[:: -(-len(rows) // most)], 4).tolist())),
            )
            for placement in predictions.placements
            for k, rows in zip(
                placement.measured.sockets, placement.measured.by_socket, strict=True
            )
        ),
    )


def travels(coverage: Coverage) -> dict[str, float]:
    """Return how far each joint that turns did over all that was trained on, by its name [rad]."""
    trained = [socket for socket in coverage.sockets if socket.role == "train"]
    return {
        joint.name: max(s.high[i] for s in trained) - min(s.low[i] for s in trained)
        for i, joint in enumerate(coverage.joints)
        if joint.unit == "rad" and trained
    }

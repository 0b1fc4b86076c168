"""How far each joint moved while recording, in each socket."""

import numpy as np

from .predictions import Predictions
from .types_report_drawing import Coverage, JointRange, SocketCoverage


def coverage(predictions: Predictions, most: int) -> Coverage:
    """Return where the joints were in each socket [rad], [m] for a prismatic joint.

    Args:
        predictions: The calibration.
        most: Samples kept of each socket; lows and highs are of all.
    """
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

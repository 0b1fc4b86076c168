"""Corrected joint positions, as expressions of what the encoders read."""

from typing import Any

import casadi as ca
import numpy as np

from ..identification.data import Load, Samples
from ..identification.model import Deflection
from ..identification.robot import Robot, moments_function


def symbolic_positions(robot: Robot, deflection: Deflection, load: Load, q: Any) -> Any:
    """Return what :meth:`.Deflection.true_positions` computes of numbers, of symbols, shape (n,).

    Args:
        robot: The robot, whose masses load its joints.
        deflection: Elasticity and transmission error of the joints.
        load: Gravity and payload.
        q: Joint positions, shape (m,) [rad].
    """
    moments = moments_function(robot, load.gravity, load.payload)(q)
    samples = Samples(_as_row(q), _as_row(moments))
    (positions,) = deflection.true_positions(samples)
    return ca.vertcat(*positions)


def _as_row(column: Any) -> np.ndarray:
    """Return a column of symbols as a row of objects, shape (1, n)."""
    count = column.numel()
    row = np.empty((1, count), dtype=object)
    row[0] = [column[i] for i in range(count)]
    return row

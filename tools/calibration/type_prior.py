"""What calibrations of other arms of a type tell of an arm's elasticity.

Each arm's geometry is its own, but how far joints and links of a type give way is much the same in
all of its arms.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...solver.auto.deflection import ELASTICITY, coefficient_names
from ...solver.auto.extended_model import Expected
from ...solver.robot.urdf import Robot
from ..documents.calibration import CalibrationDocument, read_calibration
from ..usage import UsageError

__all__ = ["type_priors"]

LEAST = 1e-9
"""No deviation is less [rad/(N m)], so that it can be divided by."""


def type_priors(files: Sequence[str | Path], robots: Sequence[Robot]) -> list[dict[str, Expected]]:
    """Return what is known of the elasticity of each robot's type, by extension.

    Where several files tell of one robot, a coefficient is their mean, weighted by its precision.

    Args:
        files: Each a ``calibration.json`` of another arm.
        robots: A file tells of those that have the same joints.

    Raises:
        UsageError: A file tells of none of the robots, or has no elasticity.
        DocumentError: A file is missing, of another format, or damaged.
    """
    documents = {str(file): read_calibration(Path(file)) for file in files}
    for file, document in documents.items():
        joints = document.model.joint_names
        if not any(tuple(robot.joint_names) == joints for robot in robots):
            known = "; ".join(", ".join(robot.joint_names) for robot in robots)
            raise UsageError(
                f"--type-prior {file}: of an arm with the joints {', '.join(joints)}, while this "
                f"has {known}"
            )
        if not any(_coefficients(document, extension) for extension in ELASTICITY):
            raise UsageError(
                f"--type-prior {file}: no elasticity was found in that arm; give calibrations "
                "that list `compliance` or `tilt` under `deflection`"
            )
    return [_of(robot, list(documents.values())) for robot in robots]


def _of(robot: Robot, documents: Sequence[CalibrationDocument]) -> dict[str, Expected]:
    """Return what is known of one robot."""
    own = [d for d in documents if d.model.joint_names == tuple(robot.joint_names)]
    expected: dict[str, Expected] = {}
    for extension in ELASTICITY:
        rows = np.array([rows for rows in (_coefficients(d, extension) for d in own) if rows])
        if len(rows):
            weights = 1 / rows[:, :, 1] ** 2
            mean = (weights * rows[:, :, 0]).sum(axis=0) / weights.sum(axis=0)
            expected[extension] = mean, weights.sum(axis=0) ** -0.5
    return expected


def _coefficients(document: CalibrationDocument, extension: str) -> list[tuple[float, float]]:
    """Return an extension's coefficients and their deviations; none where it was not found."""
    if extension not in document.deflection:
        return []
    names = coefficient_names(extension, document.model.joint_names)
    known = {
        c.name: (c.value, max(c.standard_deviation, 1e-9)) for c in document.coefficients or ()
    }
    return [known[name] for name in names if name in known]

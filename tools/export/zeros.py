"""Estimated zeros of joints that move into the arm's own file, and the URDF that is left."""

import math
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import fixed, read_bytes
from ...solver.identification.effects import JOINT_OFFSET
from ...solver.identification.inference import offsets_in_origins
from ...solver.identification.selection import is_decided
from .request import ExportError, Request

UNDECIDED = "not decided by the data, left as it is"


class JointZero(NamedTuple):
    """The estimated zero of one joint, to be added to its reading."""

    joint: str
    zero: float
    deviation: float
    """Both [rad], or [m] where the joint slides."""

    @property
    def decided(self) -> bool:
        """True if the data tell enough of it to be written."""
        return is_decided(self.zero, self.deviation)

    def __str__(self) -> str:
        zero = fixed(math.degrees(self.zero), 2, "+")
        return f"{zero} +- {math.degrees(self.deviation):.2f} deg"


def estimated_zeros(request: Request) -> list[JointZero]:
    """Return the estimated zero of each joint, in chain order; refuse readings of other signs."""
    _check_signs(request)
    document = request.calibration.document
    joints = document.model.joint_names
    names = JOINT_OFFSET.coefficient_names(joints)
    coefficients = {c.name: c for c in document.coefficients or () if c.name in names}
    if not coefficients:
        raise ExportError(
            f"--to {request.format}: no zeros were looked for; solve with --zeros"
        )
    return [
        JointZero(joint, zero.value, zero.standard_deviation)
        for joint, zero in zip(
            joints, map(coefficients.__getitem__, names), strict=True
        )
    ]


def _check_signs(request: Request) -> None:
    """Refuse zeros of joints that were read with another sign than the arm's own file knows."""
    rows = request.calibration.document.data
    for file in set(chain.from_iterable(row.files for row in rows)):
        try:
            text = read_bytes(Path(file).parent / "placement.json").decode()
        except OSError:
            continue
        if "signs=" in text:
            raise ExportError(
                f"{file}: recorded with signs=.., which {request.format} does not know; its "
                "angles turn the other way, so shift its zeros by hand"
            )


def urdf_without(request: Request, zeros: list[float]) -> bytes:
    """Return the calibrated URDF, less zeros [rad] that the arm's readings hold from now on."""
    calibrated = request.calibration.calibrated
    values = offsets_in_origins(
        calibrated.model, calibrated.parameters, calibrated.geometry, -np.array(zeros)
    )
    return replace(calibrated, exported=values).urdf(request.file.parent)

"""Calibrations of one robot that are compared, and the placements that their files hold."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....errors import MukcaError
from ....solver import results
from ....solver.assessment import measurements_of
from ....solver.data import Measurement

NOMINAL = "nominal"


class ComparisonError(MukcaError):
    """Calibrations that cannot be compared."""


@dataclass(frozen=True)
class Contender:
    """A calibration in the comparison."""

    name: str
    file: Path
    document: results.CalibrationDocument
    calibration: results.CalibratedRobot

    def trained_on(self, measured: Measurement) -> bool:
        """Return True where it was fitted to these very samples, wherever they lie now."""
        positions = [sample.position for sample in measured.placement.samples]
        return any(
            row.role == "train" and [sample.position for sample in row.samples] == positions
            for row in self.document.data
        )


def contenders_of(files: Sequence[Path]) -> list[Contender]:
    """Return the calibrations in some files, named by their folders.

    Raises:
        DocumentError: A file is no calibration.
        ComparisonError: They are not of the same joints.
    """
    contenders: list[Contender] = []
    for file, name in zip(files, _names(files), strict=True):
        document = results.read_calibration(file)
        contenders.append(
            Contender(name, file, document, results.calibrated_robot(document, str(file)))
        )
    first = contenders[0].calibration.robot
    for other in contenders:
        joints = other.calibration.robot.joint_names
        if joints != first.joint_names:
            raise ComparisonError(
                f"{other.file}: its joints are {', '.join(joints)}, but those of {files[0]} are "
                f"{', '.join(first.joint_names)}; only calibrations of one robot can be compared"
            )
    return contenders


def _names(files: Sequence[Path]) -> list[str]:
    """Return the shortest names that tell files apart: folder, folders, path."""
    for count in (1, 2):
        names = ["/".join(file.resolve().parent.parts[-count:]) for file in files]
        if len({*names, NOMINAL}) == len(names) + 1:
            return names
    if len(set(files)) < len(files):
        raise ComparisonError("a calibration is named twice; name each only once")
    return [str(file) for file in files]


def shared_data(contenders: Sequence[Contender]) -> list[Measurement]:
    """Return all placements that the calibrations' files hold, each once."""
    robot = contenders[0].calibration.robot
    shared: list[Measurement] = []
    for contender in contenders:
        earlier = [m.placement.positions for m in shared]
        shared += [
            m
            for m in measurements_of(contender.document, robot, str(contender.file))
            if not any(np.array_equal(m.placement.positions, positions) for positions in earlier)
        ]
    return shared

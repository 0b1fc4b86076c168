"""Model of a fold, as ``calibration.json`` keeps it beside that of the fit to all."""

from dataclasses import replace

import numpy as np

from ..identification.model import Deflection
from .calibrated import CalibratedRobot, Place
from .files import Document


class FoldModel(Document):
    """The model of a fold, in the parameters of the calibration."""

    values: tuple[float, ...]
    """Of the parameters [m, rad]."""
    exported: tuple[float, ...]
    """The same for a URDF alone."""
    deflection: dict[str, tuple[float, ...]]
    """Coefficients of each extension of the geometry."""
    ball: Place | None
    """The nominal ball in its link, refitted [m]."""

    @classmethod
    def of(cls, calibrated: CalibratedRobot, ball: Place | None) -> "FoldModel":
        """Return what a document keeps of a calibrated robot."""
        by_name = calibrated.deflection.by_name
        return cls(
            values=tuple(calibrated.values.tolist()),
            exported=tuple(calibrated.geometry.tolist()),
            deflection={name: tuple(row.tolist()) for name, row in by_name.items()},
            ball=ball,
        )

    def robot(self, calibrated: CalibratedRobot) -> CalibratedRobot:
        """Return the calibrated robot with the numbers of this fold."""
        coefficients = tuple(map(np.array, self.deflection.values()))
        return replace(
            calibrated,
            values=np.array(self.values),
            deflection=Deflection(tuple(self.deflection), coefficients),
            exported=np.array(self.exported) if self.deflection else None,
        )

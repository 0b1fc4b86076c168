"""The table of studies of a fit: each writes one section of ``calibration.json``."""

from ..results import Study
from .better import BETTER
from .error_curves import CURVES, WARNINGS
from .frames import FRAMES
from .held_out_error import ERROR_PARTS
from .knowledge import UNCERTAINTY
from .patterns import ERROR_PATTERNS
from .placement_deviations import LEFT_OUT, MISFIT, PLACEMENTS
from .size import SCALE
from .standard_deviations import COEFFICIENTS, GROUPS, PARAMETERS

STUDIES: tuple[Study, ...] = (
    PARAMETERS,
    COEFFICIENTS,
    GROUPS,
    PLACEMENTS,
    LEFT_OUT,
    MISFIT,
    CURVES,
    WARNINGS,
    ERROR_PARTS,
    ERROR_PATTERNS,
    FRAMES,
    BETTER,
    UNCERTAINTY,
    SCALE,
)

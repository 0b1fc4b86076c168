"""The table of studies of a fit: each writes one section of ``calibration.json``."""

from ..results import Study
from .error_curves import CURVES, WARNINGS
from .frames import FRAMES
from .held_out_error import ERROR_PARTS
from .identifiability import UNCERTAINTY
from .improvement import BETTER
from .patterns import ERROR_PATTERNS
from .placement_deviations import LEFT_OUT, MISFIT, PLACEMENTS, TAIL
from .uncertainty import SCALE

STUDIES: tuple[Study, ...] = (
    PLACEMENTS,
    LEFT_OUT,
    MISFIT,
    TAIL,
    CURVES,
    WARNINGS,
    ERROR_PARTS,
    ERROR_PATTERNS,
    FRAMES,
    BETTER,
    UNCERTAINTY,
    SCALE,
)

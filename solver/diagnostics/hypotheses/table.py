"""The table of explanations.

To add one, write a :class:`.Kind` in a file of its noun: its prior, its unknowns as columns of the
residuals, its words, and what tells it from others; then add it below, and what it looks like to
docs/causes/pages.py, which writes its page.
"""

from .ball import BALL_BENT, BALL_LOOSE, BALL_LOOSE_HERE, BALL_SAMPLE
from .base import BASE_BETWEEN, BASE_MOVED, DRIFT
from .distance import DISTANCE, KNOWN, ONE_SOCKET, SCALED
from .geometry import ANGLE, LENGTH, OTHER_ARM, VERSION_WRONG
from .joints import GAIN, LAG, ZERO, ZERO_LOST
from .kinds import Kind, NoisePrior
from .mounting import MOUNTING
from .recording import COPIES, PUSHED_ARM, PUSHED_HERE, QUANTISED
from .socket import SOCKET

SOUND = Kind("sound", 1.0, lambda p: "nothing wrong was seen", "")
UNEXPLAINED = Kind(
    "unexplained",
    0.01,
    lambda p: f"the samples scatter by {1e3 * p['noise']:.2f} mm, and no single cause explains it",
    "is it this robot's model, with the right --base and --tip, and the joints in order?",
    "record one more placement with care",
    code="model",
    noise=lambda scene: NoisePrior(1e-2, 2.0, below=False),
)
KINDS: tuple[Kind, ...] = (
    SOUND,
    DISTANCE,
    SCALED,
    ONE_SOCKET,
    KNOWN,
    LENGTH,
    ANGLE,
    VERSION_WRONG,
    OTHER_ARM,
    ZERO,
    ZERO_LOST,
    GAIN,
    LAG,
    BASE_MOVED,
    BASE_BETWEEN,
    DRIFT,
    BALL_SAMPLE,
    BALL_BENT,
    BALL_LOOSE,
    BALL_LOOSE_HERE,
    SOCKET,
    MOUNTING,
    COPIES,
    QUANTISED,
    PUSHED_ARM,
    PUSHED_HERE,
    UNEXPLAINED,
)
ONLY_SOUND: tuple[Kind, ...] = (SOUND,)
OF_SIZE: tuple[Kind, ...] = (DISTANCE,)
CURABLE: tuple[Kind, ...] = (
    SOUND,
    DISTANCE,
    BASE_MOVED,
    DRIFT,
    BALL_SAMPLE,
    BALL_BENT,
    BALL_LOOSE,
    ZERO_LOST,
)
"""Those that a hand can cure while it records."""

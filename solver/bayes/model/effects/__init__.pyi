from .compliance import COMPLIANCE as COMPLIANCE
from .effect import Effect as Effect
from .joint_offset import JOINT_OFFSET as JOINT_OFFSET
from .table import EFFECTS as EFFECTS
from .table import EXTENSIONS as EXTENSIONS
from .tilt import TILT as TILT
from .transmission import HARMONICS as HARMONICS

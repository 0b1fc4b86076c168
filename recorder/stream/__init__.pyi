from .monitor import JUMP as JUMP
from .monitor import ContactDetector as ContactDetector
from .monitor import StreamMonitor as StreamMonitor
from .stationarity import STILL as STILL
from .stationarity import WINDOW as WINDOW
from .stationarity import JointLimits as JointLimits
from .stationarity import StationaryPose as StationaryPose
from .stream import Stream as Stream

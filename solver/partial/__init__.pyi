# keep: Zeros, Tool, CameraPose
from .camera_pose import Camera as Camera
from .camera_pose import CameraPose as CameraPose
from .camera_pose import handeye as handeye
from .joint_zeros import Zeros as Zeros
from .joint_zeros import rezero as rezero
from .tool_tip import Tool as Tool
from .tool_tip import tool as tool

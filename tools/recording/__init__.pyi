from .beside import goal_for as goal_for
from .coach import SHARE as SHARE
from .coach import PoseSelector as PoseSelector
from .opening import is_scripted as is_scripted
from .opening import joints_of as joints_of
from .opening import record_session as record_session
from .quick import standing as standing
from .quick import worth_calibrating as worth_calibrating

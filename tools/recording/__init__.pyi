# keep: BackgroundGuidance
from .checks import worth_calibrating as worth_calibrating
from .distance_question import with_distance as with_distance
from .distance_question import with_second_reading as with_second_reading
from .earlier_placements import recorded_beside as recorded_beside
from .goals import goal_for as goal_for
from .goals import limit_for as limit_for
from .guidance import SHARE as SHARE
from .guidance import PoseSelector as PoseSelector
from .guidance_process import BackgroundGuidance as BackgroundGuidance
from .options import RecordOptions as RecordOptions
from .options import joints_of as joints_of
from .session_alarms import SessionAlarms as SessionAlarms
from .session_start import SessionStart as SessionStart
from .session_start import page_of as page_of
from .setup import record_session as record_session
from .stops import record_stops as record_stops
from .zero_guidance import ZeroSelector as ZeroSelector

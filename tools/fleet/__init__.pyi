# keep: FleetArm, FleetSession
from .calibrate import ArmFolder as ArmFolder
from .calibrate import calibrate_arm as calibrate_arm
from .calibrate import compare_curves as compare_curves
from .calibrate import compare_parameters as compare_parameters
from .calibrate import find_arms as find_arms
from .calibrate import find_copies as find_copies
from .calibrate import last_sessions as last_sessions
from .document import FORMAT as FORMAT
from .document import FleetArm as FleetArm
from .document import FleetCurves as FleetCurves
from .document import FleetDocument as FleetDocument
from .document import FleetSession as FleetSession
from .page import fleet_page as fleet_page
from .page import line_of as line_of
from .page import months_of as months_of
from .page import summary_of as summary_of
from .page import urgency as urgency

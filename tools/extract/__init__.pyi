from .log import Log as Log
from .log import Question as Question
from .propose import Proposal as Proposal
from .propose import assign as assign
from .propose import placements_of as placements_of
from .rests import find_rests as find_rests
from .sources import read_log as read_log

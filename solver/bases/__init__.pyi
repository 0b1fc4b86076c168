from .meetings import base_to_base as base_to_base
from .places import Visitor as Visitor
from .places import base_name as base_name
from .places import common_places as common_places
from .places import places_alone as places_alone
from .ties import TiedRobots as TiedRobots
from .ties import tie as tie

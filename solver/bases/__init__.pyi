from .base_to_base import base_to_base as base_to_base
from .frames import frames_of_robots as frames_of_robots
from .places_alone import places_alone as places_alone
from .ties import TiedRobots as TiedRobots
from .ties import tie as tie
from .views import Visitor as Visitor

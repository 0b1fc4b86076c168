from .pages import comparison_page as comparison_page
from .pages import fleet_page as fleet_page
from .pages import line_of as line_of
from .pages import report_page as report_page
from .pages import simulation_page as simulation_page
from .pages import summary_of as summary_of

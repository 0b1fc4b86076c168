from .pages import comparison_page as comparison_page
from .pages import found_page as found_page
from .pages import render as render
from .pages import report_page as report_page
from .pages import simulation_page as simulation_page

from .build import build_comparison as build_comparison
from .build import build_report as build_report
from .build import render as render
from .build import report_files as report_files
from .build import simulation_page as simulation_page
from .build import write_report as write_report
from .console import show as show
from .console import show_verdict as show_verdict

from .build import build_report as build_report
from .build import report_files as report_files
from .build import write_report as write_report
from .console import show as show
from .console import show_verdict as show_verdict

from .comparison_page import comparison_plots as comparison_plots
from .comparison_page import sentence as sentence
from .fleet_page import line_of as line_of
from .fleet_page import summary_of as summary_of
from .report_page import page as page
from .report_page import plots_of as plots_of

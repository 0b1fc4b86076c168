from .comparison import comparison_plots as comparison_plots
from .comparison import simulation_plot as simulation_plot
from .figure import Axis as Axis
from .figure import named_rows as named_rows
from .model import shown_unit as shown_unit
from .plot import Plot as Plot
from .samples import map_sentence as map_sentence
from .sections import plots_of as plots_of

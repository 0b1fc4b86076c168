from .axes import Axis as Axis
from .axes import Panel as Panel
from .axes import Rows as Rows
from .model import shown_unit as shown_unit
from .plot import Maker as Maker
from .plot import Plot as Plot
from .use import map_sentence as map_sentence

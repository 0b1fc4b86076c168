from .formats import FORMATS as FORMATS
from .writer import export as export

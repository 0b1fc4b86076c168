from .model_selection import Selected as Selected
from .model_selection import select_all as select_all

from .export import Exported as Exported
from .export import Request as Request
from .export import identify as identify
from .formats import FORMATS as FORMATS

from .formats import FORMATS as FORMATS
from .formats import export as export
from .formats import format_table as format_table
from .lerobot import with_zeros as with_zeros
from .request import Exported as Exported
from .request import ExportError as ExportError
from .request import Request as Request
from .request import losses_without as losses_without

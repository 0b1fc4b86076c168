from .processes import Workers as Workers
from .processes import started_apart as started_apart

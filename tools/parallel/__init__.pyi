from .processes import Workers as Workers
from .processes import add_workers as add_workers
from .processes import workers_of as workers_of

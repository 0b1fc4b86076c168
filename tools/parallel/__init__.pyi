from .processes import Workers as Workers

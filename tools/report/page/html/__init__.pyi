from .cells import Cell as Cell
from .cells import figure as figure
from .cells import table as table
from .markup import Element as Element
from .markup import Node as Node
from .markup import tag as tag

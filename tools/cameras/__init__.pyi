from .boards import JOINTS as JOINTS
from .boards import Board as Board
from .boards import read_images as read_images
from .postures import joints_of as joints_of
from .turned_boards import turned_alike as turned_alike

from .known_file import in_placements as in_placements
from .known_file import parse_known as parse_known
from .known_file import parse_socket_at as parse_socket_at
from .known_file import read_known as read_known
from .known_file import read_sockets_at as read_sockets_at
from .leave_out import check_left_out as check_left_out
from .leave_out import parse_left_out as parse_left_out
from .leave_out import without as without

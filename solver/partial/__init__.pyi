# keep: Zeros
from .joint_zeros import Zeros as Zeros
from .joint_zeros import rezero as rezero

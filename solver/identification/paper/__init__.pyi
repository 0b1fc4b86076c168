from .problem import REGULARIZATION as REGULARIZATION
from .problem import Problem as Problem
from .problem import build_problem as build_problem
from .problem import covariance as covariance
from .problem import solve as solve

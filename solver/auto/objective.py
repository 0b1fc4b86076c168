"""What the default method minimises (the objective), and where the search stands (the state).

docs/model.md introduces prior, posterior and evidence.

The unknowns are x, the geometry and the coefficients of the extensions, and the socket centres
m_s. Given the widths of the priors and the noise, the most plausible unknowns minimise

    L =  sum over samples  t(e_i; C_i)              e_i = Phi(x, q_i) - m_s(i)             (A1)
       + |W (l - d)|^2 / 2                          l_k = |m_b - m_a|, of measured distances d
       + sum over groups  x_g^T P_g x_g / 2         P_g = (s_g^2 I + t_g t_g^T)^-1
       - (1 - S / N) sum over samples  log V_i          V_i = sqrt(det(Jq_i Jq_i^T))

Line by line: the predicted balls should be at their sockets' centres, the sockets should be as far
apart as they were measured to be, the unknowns should be near their priors, and the robot should
not shrink.

- Phi(x, q_i) is the predicted ball of sample i, and s(i) the socket that it sat in.
- t is minus the logarithm of Student's distribution, with nu = 5, of whole 3-vectors, so that a
  sample far from its socket weighs little. C_i is its scale, see :mod:`mukca.solver.auto.noise`.
- l_k is the distance between sockets a and b by the model, d_k the measured one. W^T W is the
  inverse covariance of the measured distances; placements of one base share the error of its
  measurement.
- P_g is the prior precision (inverse covariance) of a group of unknowns, s_g its width, and t_g a
  common change that is allowed beside it, see :mod:`mukca.solver.auto.priors`.
- The last term is there because a model that shrinks the robot shrinks all errors, too, and would
  seem better for that alone. What is known are N joint positions; a small box of joint positions
  about q_i leads to a body of ball positions whose volume is V_i times as large, and V_i grows with
  the cube of the robot's scale. The S socket centres are unknown and shrink along with the robot,
  so only N - S samples count.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..data.observations import Observations
from .extended_model import ExtendedModel
from .noise import Noise
from .priors import PriorGroup, prior_groups

__all__ = [
    "Linear",
    "Objective",
    "State",
    "build_objective",
    "distance_rows",
    "free_unknowns",
    "linearise",
    "prior_precision",
    "priors",
    "start",
]


@dataclass(frozen=True)
class Objective:
    """What stays the same in all iterations: the model, the data, and two constant terms of L."""

    model: ExtendedModel
    data: Observations
    nominal_log_volume: float
    """Mean of log V_i of the nominal robot."""
    whiten: np.ndarray
    """W, for K measured distances, shape (K, K) [1/m]."""

    @property
    def size(self) -> int:
        """Number n of unknowns, three for each socket centre included."""
        return self.model.size + 3 * self.data.socket_count


@dataclass(frozen=True)
class Linear:
    """The samples' errors at some unknowns, and their derivatives."""

    points: np.ndarray
    """Phi(x, q_i), shape (N, 3) [m]."""
    errors: np.ndarray
    """e_i, shape (N, 3) [m]."""
    by_unknowns: np.ndarray
    """J_i, derivatives of the ball's position by x, shape (N, 3, size)."""
    by_joints: np.ndarray
    """Jq_i, derivatives of the ball's position by the joint positions, shape (N, 3, m)."""
    volume: float
    """The last term of L."""
    by_volume: np.ndarray
    """Its derivatives by all unknowns, shape (n,)."""


@dataclass(frozen=True)
class State:
    """Where the estimation stands between two iterations."""

    x: np.ndarray
    """Unknowns of the model, shape (size,)."""
    centres: np.ndarray
    """Centres of the sockets, shape (S, 3) [m]."""
    groups: tuple[PriorGroup, ...]
    """The priors, at their present widths."""
    noise: Noise
    """The noise, at its present size."""
    at_zero: np.ndarray
    """Which of x are held at zero, shape (size,)."""
    linear: Linear
    """Errors and derivatives at x and the centres."""


def build_objective(model: ExtendedModel, data: Observations) -> Objective:
    """Return the objective of a model and data."""
    log_volume, _ = model.ball.log_volume(model.ball.nominal, data.positions)
    whiten = np.linalg.inv(np.linalg.cholesky(data.distance_covariance()))
    return Objective(model, data, log_volume, whiten)


def start(objective: Objective, joint_noise: bool) -> State:
    """Return the first state: the nominal robot, each socket at the median of its balls.

    Args:
        objective: What will be minimised.
        joint_noise: Whether the joint angles may be noisy.
    """
    model, data = objective.model, objective.data
    x = np.zeros(model.size)
    nominal = linearise(objective, x, np.zeros((data.socket_count, 3)))
    centres = np.array(
        [np.median(nominal.points[data.sockets == k], axis=0) for k in range(data.socket_count)]
    )
    linear = replace(nominal, errors=nominal.points - centres[data.sockets])
    typical = float(np.median(np.linalg.norm(linear.errors, axis=1))) / 1.54
    squares: np.ndarray = np.sum(linear.by_joints**2, axis=(1, 2)) / 3
    reach = float(np.mean(squares)) ** 0.5
    noise = Noise(max(typical, 1e-7), typical / reach if joint_noise else 0.0)
    groups = prior_groups(model, data)
    return State(x, centres, groups, noise, np.zeros(model.size, dtype=bool), linear)


def linearise(objective: Objective, x: np.ndarray, centres: np.ndarray) -> Linear:
    """Return the samples' errors and their derivatives at some unknowns."""
    model, data = objective.model, objective.data
    points, by_x, by_joints = model.linearise(x, data.positions, data.torques)
    log_volume, slope = model.ball.log_volume(model.values(x), data.positions)
    count = len(points) - data.socket_count
    by_volume = np.zeros(objective.size)
    by_volume[: model.geometry] = -count * slope
    volume = -count * (log_volume - objective.nominal_log_volume)
    errors = points - centres[data.sockets]
    return Linear(points, errors, by_x, by_joints, volume, by_volume)


def distance_rows(objective: Objective, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return what the measured distances add to the least-squares problem.

    Returns:
        W B, shape (K, n), where B is the derivative of the distances by all unknowns; and
        W (l - d), shape (K,): how far each distance is off, relative to its uncertainty.
    """
    known = objective.data.known
    rows = np.zeros((len(known), objective.size))
    values = np.zeros(len(known))
    for i, k in enumerate(known):
        offset = state.centres[k.second] - state.centres[k.first]
        length = float(np.linalg.norm(offset))
        for socket, sign in ((k.second, 1), (k.first, -1)):
            begin = objective.model.size + 3 * socket
            rows[i, begin : begin + 3] = sign * offset / length
        values[i] = length - k.distance
    return objective.whiten @ rows, objective.whiten @ values


def priors(state: State) -> list[tuple[PriorGroup, np.ndarray]]:
    """Return the groups that have a width, and the members of each that are not held."""
    kept = [(g, g.members[~state.at_zero[g.members]]) for g in state.groups if g.width]
    return [(group, members) for group, members in kept if len(members)]


def free_unknowns(objective: Objective, state: State) -> np.ndarray:
    """Return which of all unknowns are not held at zero, shape (n,)."""
    free = np.ones(objective.size, dtype=bool)
    free[: objective.model.size] = False
    for _, members in priors(state):
        free[members] = True
    return free


def prior_precision(objective: Objective, state: State, *, widened: bool = False) -> np.ndarray:
    """Return P of all unknowns, shape (n, n); zero for the centres and what is held.

    Args:
        objective: The objective.
        state: Its groups.
        widened: Whether to count that the widths are uncertain themselves.
    """
    P = np.zeros((objective.size, objective.size))
    for group, members in priors(state):
        width = group.deviation if widened else group.width
        P[np.ix_(members, members)] = group.precision(members, width)
    return P

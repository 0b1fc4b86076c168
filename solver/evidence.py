"""Maximum a posteriori estimation whose prior widths and noise the data decide by evidence.

The unknowns x are the geometry, the coefficients of extensions and the socket centres m_s.
Given hyperparameters, the posterior's maximum minimises

    sum over samples  t(e_i; C_i)        e_i = Phi(x, q_i) - m_s(i)
  + sum over known distances  ((|m_a - m_b| - d) / s_d)^2 / 2
  + sum over groups  |x_g|^2 / (2 s_g^2)

where t is Student's distribution with nu = 5 of whole 3-vectors, and C_i = s_x^2 I + s_q^2 Jq Jq^T
its scale: noise in space, and noise of the joint angles. Each iteration takes one Gauss-Newton step
with reweighting, and one fixed-point step for s_g, s_x and s_q towards the maximum of the evidence
(MacKay 1992; for the noise, Harville 1977), so that a group without support vanishes.
"""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from dataclasses import replace
from math import lgamma, log, pi

import numpy as np
from numpy.typing import NDArray

from .deflection import COMPLIANCE, EXTENSIONS
from .estimate import INFORMATION, NU, Estimate
from .map_problem import NEGLIGIBLE, Group, MapProblem, Noise
from .optimizers import NotConverged

__all__ = ["estimate"]

Vector = NDArray[np.float64]
MAX_ITERATIONS = 150


def estimate(problem: MapProblem, joint_noise: bool = True) -> Estimate:
    """Solve a problem from the nominal model.

    Args:
        problem: What to solve.
        joint_noise: Whether the joint angles' noise may be other than zero.

    Raises:
        NotConverged: The hyperparameters did not settle.
    """
    return _Iteration(problem, joint_noise).run()


class _Iteration:
    """The state of the estimation between steps."""

    def __init__(self, problem: MapProblem, joint_noise: bool) -> None:
        data = problem.data
        self.problem = problem
        self.groups = problem.groups
        self.x = np.zeros(problem.size)
        self.fixed = np.zeros(problem.size, dtype=bool)
        self.iterates = [self.x]
        self.evaluate()
        sockets = range(data.socket_count)
        self.centres = np.array(
            [np.median(self.points[data.sockets == k], axis=0) for k in sockets]
        )
        typical = float(np.median(np.linalg.norm(self.residuals, axis=1))) / 1.54
        reach = float(np.sqrt(np.mean(np.sum(self.by_joints**2, axis=(1, 2)) / 3)))
        self.noise = Noise(max(typical, 1e-7), typical / reach if joint_noise else 0.0)
        self.evaluations = 1
        self.released = False

    @property
    def residuals(self) -> Vector:
        return self.points - self.centres[self.problem.data.sockets]

    def evaluate(self) -> None:
        data = self.problem.data
        self.points, by_x, self.by_joints = self.problem.linearise(
            self.x, data.positions, data.torques
        )
        by_centres = np.zeros((len(by_x), 3, 3 * data.socket_count))
        for axis in range(3):
            by_centres[np.arange(len(by_x)), axis, 3 * data.sockets + axis] = -1
        self.jacobian = np.concatenate([by_x, by_centres], axis=2)

    def run(self) -> Estimate:
        for _ in range(MAX_ITERATIONS):
            if self.step() < 1e-2 and not self.prune() and not self.release():
                return self.result()
        raise NotConverged(f"auto did not settle in {MAX_ITERATIONS} iterations; see mukca check")

    def prune(self) -> bool:
        """Take out what has no effect beside the noise; tell whether there was any."""
        gone = [g for g in self.groups if g.width and self.effect(g) < NEGLIGIBLE]
        for group in gone:
            self.fixed[group.members] = True
            self.x[group.members] = 0.0
        self.groups = tuple(
            replace(g, width=0.0, effective=0.0, learned=False) if g in gone else g
            for g in self.groups
        )
        if self.noise.joint and self.joint_effect() < NEGLIGIBLE:
            self.noise = replace(self.noise, joint=0.0)
            return True
        return bool(gone)

    def effect(self, group: Group) -> float:
        """Return how far an extension's width moves the ball, relative to the noise."""
        if group.name not in EXTENSIONS:
            return np.inf
        members = group.members[~self.fixed[group.members]]
        squares = np.sum(self.jacobian[:, :, members] ** 2, axis=(1, 2)) / 3
        return group.width * float(np.sqrt(np.mean(squares))) / self.noise.space

    def joint_effect(self) -> float:
        """Return how far the noise of the joints moves the ball, relative to that in space."""
        squares = np.sum(self.by_joints**2, axis=(1, 2)) / 3
        return self.noise.joint * float(np.sqrt(np.mean(squares))) / self.noise.space

    def weigh(self) -> tuple[Vector, Vector]:
        """Return the inverse scales C_i^-1, shape (N, 3, 3), and squared distances e C^-1 e."""
        inverse: Vector = np.linalg.inv(self.noise.scales(self.by_joints)).astype(np.float64)
        e = self.residuals
        squares = np.einsum("ni,nij,nj->n", e, inverse, e)
        self.weights = (NU + 3) / (NU + squares)
        return inverse, squares

    def precisions(self) -> Vector:
        """Return the prior precision of every unknown, infinite for those that stay at zero."""
        prior = np.zeros(self.jacobian.shape[2])
        for group in self.groups:
            prior[group.members] = group.width**-2 if group.width else np.inf
        prior[: self.problem.size][self.fixed] = np.inf
        return prior

    def step(self) -> float:
        """Take one step of everything; return the largest relative change of a scale."""
        inverse, _ = self.weigh()
        whitened = np.linalg.cholesky(inverse * (INFORMATION * self.weights)[:, None, None])
        A = (whitened.transpose(0, 2, 1) @ self.jacobian).reshape(-1, self.jacobian.shape[2])
        r = (whitened.transpose(0, 2, 1) @ self.residuals[:, :, None]).ravel() / INFORMATION
        B, b = self.distance_rows()
        prior = self.precisions()
        free = np.isfinite(prior)
        A_free, B_free = A[:, free], B[:, free]
        self.hessian = A_free.T @ A_free + B_free.T @ B_free + np.diag(prior[free])
        x = np.concatenate([self.x, np.zeros(self.centres.size)])[free]
        gradient = A_free.T @ r + B_free.T @ b + prior[free] * x
        self.free = free
        self.covariance = _inverse(self.hessian)
        step = np.zeros(len(free))
        step[free] = -self.covariance @ gradient
        self.move(step)
        return max(self.update_groups(), self.update_noise(inverse, step))

    def move(self, step: Vector) -> None:
        x = self.x + step[: self.problem.size]
        for group in self.groups:
            if group.name == COMPLIANCE:  # a joint that would bend against its load does not bend
                below = group.members[x[group.members] < 0]
                x[below] = 0.0
                self.fixed[below] = True
        self.x = x
        self.iterates.append(x)
        self.residuals_before = self.residuals
        self.centres = self.centres + step[self.problem.size :].reshape(-1, 3)
        self.jacobian_before, self.by_joints_before = self.jacobian, self.by_joints
        self.evaluate()
        self.evaluations += 1

    def distance_rows(self) -> tuple[Vector, Vector]:
        """Return Jacobian and residuals of the known distances, over their deviations."""
        known = self.problem.data.known
        rows = np.zeros((len(known), self.jacobian.shape[2]))
        values = np.zeros(len(known))
        for i, k in enumerate(known):
            offset = self.centres[k.second] - self.centres[k.first]
            length = float(np.linalg.norm(offset))
            for socket, sign in ((k.second, 1), (k.first, -1)):
                begin = self.problem.size + 3 * socket
                rows[i, begin : begin + 3] = sign * offset / length / k.deviation
            values[i] = (length - k.distance) / k.deviation
        return rows, values

    def update_groups(self) -> float:
        """Take one step for the widths; return the largest relative change of those that matter."""
        variances = np.zeros(len(self.free))
        variances[self.free] = np.diag(self.covariance)
        updated: list[Group] = []
        change = 0.0
        for group in self.groups:
            new = group
            if group.learned:
                members = group.members[~self.fixed[group.members]]
                effective = len(members) - float(variances[members].sum()) / group.width**2
                new = group.updated(float(np.sum(self.x[members] ** 2)), effective)
                if self.effect(new) > NEGLIGIBLE:
                    change = max(change, abs(log(new.width / group.width)))
            updated.append(new)
        self.groups = tuple(updated)
        return change

    def update_noise(self, inverse: Vector, step: Vector) -> float:
        """Take one step of Fisher scoring for s_x^2 and s_q^2; return the relative change.

        The score of each is what is left over of it in the residuals, less what was to be
        expected in the directions that the fit leaves to it (restricted maximum likelihood).
        """
        w = self.weights
        e = self.residuals_before + self.jacobian_before @ step
        u = np.einsum("nij,nj->ni", inverse, e)
        J = self.jacobian_before[:, :, self.free]
        leverage = (J @ self.covariance) @ J.transpose(0, 2, 1)
        left = inverse - INFORMATION * w[:, None, None] * inverse @ leverage @ inverse
        Jq = self.by_joints_before
        kinds = [np.broadcast_to(np.eye(3), inverse.shape), Jq @ Jq.transpose(0, 2, 1)]
        kinds = kinds if self.noise.joint else kinds[:1]
        score = [
            float(np.sum(w * np.einsum("ni,nij,nj->n", u, V, u)) - np.sum(left * V)) for V in kinds
        ]
        scaled = [inverse @ V for V in kinds]
        fisher = [[float(np.sum(A * B.transpose(0, 2, 1))) for B in scaled] for A in scaled]
        before, matters = self.noise, self.joint_effect() > NEGLIGIBLE
        squares: Vector = np.linalg.solve(fisher, score).astype(np.float64)
        self.noise = before.updated(squares, self.joint_effect())
        return max(
            abs(log(self.noise.space / before.space)),
            abs(log(self.noise.joint / before.joint)) if matters else 0.0,
        )

    def release(self) -> bool:
        """Let compliances that were held at zero go once more; tell whether there are any."""
        members = [g.members for g in self.groups if g.name == COMPLIANCE and g.learned]
        if self.released or not members or not self.fixed[members[0]].any():
            return False
        self.fixed[members[0]] = False
        self.released = True
        return True

    def result(self) -> Estimate:
        full = np.zeros((len(self.free), len(self.free)))
        full[np.ix_(self.free, self.free)] = self.widened_covariance()
        _, squares = self.weigh()
        return Estimate(
            self.problem,
            self.x,
            self.centres,
            full,
            self.groups,
            self.noise,
            self.points,
            self.weights * NU / (NU + 3),
            self.log_evidence(squares),
            self.evaluations,
            tuple(self.iterates),
        )

    def widened_covariance(self) -> Vector:
        """Return the covariance with the priors as wide as they may well be."""
        change = np.zeros(len(self.free))
        for group in self.groups:
            if group.width:
                change[group.members] = group.deviation**-2 - group.width**-2
        return _inverse(self.hessian + np.diag(change[self.free]))

    def log_evidence(self, squares: Vector) -> float:
        """Return the logarithm of the evidence, by Laplace's approximation."""
        N = len(squares)
        scales = np.linalg.slogdet(self.noise.scales(self.by_joints))[1]
        constant = lgamma((NU + 3) / 2) - lgamma(NU / 2) - 1.5 * log(NU * pi)
        value = N * constant - 0.5 * scales.sum() - 0.5 * (NU + 3) * np.log1p(squares / NU).sum()
        value -= 0.5 * float(np.sum(self.distance_rows()[1] ** 2))
        for group in self.groups:
            members = group.members[~self.fixed[group.members]]
            if group.width and len(members):
                value -= 0.5 * float(np.sum(self.x[members] ** 2)) / group.width**2
                value -= len(members) * log(group.width)
                value -= 0.5 * (group.width / group.scale) ** 2
        return float(value - 0.5 * np.linalg.slogdet(self.hessian)[1])


def _inverse(H: Vector) -> Vector:
    """Return the inverse of a positive definite matrix whose rows differ in scale."""
    scale = 1 / np.sqrt(np.diag(H))
    return np.linalg.inv(H * scale[:, None] * scale) * scale[:, None] * scale

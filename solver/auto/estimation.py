"""Maximum a posteriori estimation whose prior widths and noise the data decide by evidence.

The unknowns x are the geometry, the coefficients of extensions and the socket centres m_s.
Given hyperparameters, the posterior's maximum minimises

    sum over samples  t(e_i; C_i)        e_i = Phi(x, q_i) - m_s(i)
  + |W (l - d)|^2 / 2             l_k = |m_a - m_b|, of the known distances d
  + sum over groups  x_g^T P_g x_g / 2                            P_g = (s_g^2 I)^-1
  - 3 (N - S) log(scale)          of the cloud of ball positions in the workspace

where t is Student's distribution with nu = 5 of whole 3-vectors, and C_i = s_x^2 I + s_q^2 Jq Jq^T
its scale: noise in space, and noise of the joint angles. W^T W is the inverse covariance of the
known distances; placements of one base share the error of its measurement. P_g of the translations
leaves the scale of all lengths together to the known distances. The last term is there because a
model that shrinks shrinks its errors, and would seem the better for it: what is given are N joint
positions, and the volume that maps to a volume of theirs grows with the cube of the scale; S
samples' worth goes to the sockets, which shrink too.

Each iteration takes one Gauss-Newton step with reweighting, and one fixed-point step for s_g, s_x
and s_q towards the maximum of the evidence (MacKay 1992; for the noise, Harville 1977), so that a
group without support vanishes.
"""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from dataclasses import replace
from math import lgamma, log, pi

import numpy as np
from numpy.typing import NDArray

from ..paper.optimizers import NotConverged
from .deflection import COMPLIANCE, EXTENSIONS
from .extended_model import MapProblem
from .posterior import INFORMATION, NU, Estimate
from .priors import NEGLIGIBLE, Group, Noise

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
        self.volume = np.concatenate([problem.by_scale(), np.zeros(3 * data.socket_count)])
        self.volume *= 3 * (len(data.sockets) - data.socket_count)
        self.whiten = np.linalg.inv(np.linalg.cholesky(data.distance_covariance()))
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
        try:
            for _ in range(MAX_ITERATIONS):
                if self.step() < 1e-2 and not self.prune() and not self.release():
                    return self.result()
        except np.linalg.LinAlgError:
            raise NotConverged("auto diverged; see mukca check, or try --method paper") from None
        raise NotConverged(f"auto did not settle in {MAX_ITERATIONS} iterations; see mukca check")

    def prune(self) -> bool:
        """Take out what has no effect beside the noise; tell whether there was any."""
        extensions = [g for g in self.groups if g.name in EXTENSIONS and g.width]
        gone = [g for g in extensions if self.effect(g) < NEGLIGIBLE]
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
        """Return how far a group's width moves the ball, relative to the noise."""
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

    def priors(self) -> list[tuple[Group, NDArray[np.int64]]]:
        """Return the groups, and the members of each that are free."""
        kept = [(g, g.members[~self.fixed[g.members]]) for g in self.groups if g.width]
        return [(group, members) for group, members in kept if len(members)]

    def find_free(self) -> NDArray[np.bool_]:
        """Return which unknowns do not stay at zero."""
        free = np.ones(self.jacobian.shape[2], dtype=bool)
        free[: self.problem.size] = False
        for _, members in self.priors():
            free[members] = True
        return free

    def prior_precision(self, widened: bool = False) -> Vector:
        """Return the prior precision of all unknowns; no row for those that stay at zero.

        Args:
            widened: Whether the uncertainty of the widths counts.
        """
        P = np.zeros((self.jacobian.shape[2],) * 2)
        for group, members in self.priors():
            width = group.deviation if widened else group.width
            P[np.ix_(members, members)] = group.precision(members, width)
        return P[np.ix_(self.free, self.free)]

    def step(self) -> float:
        """Take one step of everything; return the largest relative change of a scale."""
        inverse, _ = self.weigh()
        whitened = np.linalg.cholesky(inverse * (INFORMATION * self.weights)[:, None, None])
        A = (whitened.transpose(0, 2, 1) @ self.jacobian).reshape(-1, self.jacobian.shape[2])
        r = (whitened.transpose(0, 2, 1) @ self.residuals[:, :, None]).ravel() / INFORMATION
        B, b = self.distance_rows()
        free = self.free = self.find_free()
        prior = self.prior_precision()
        A_free, B_free = A[:, free], B[:, free]
        self.hessian = A_free.T @ A_free + B_free.T @ B_free + prior
        x = np.concatenate([self.x, np.zeros(self.centres.size)])[free]
        gradient = A_free.T @ r + B_free.T @ b + prior @ x - self.volume[free]
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
        """Return Jacobian and residuals of the known distances, whitened."""
        known = self.problem.data.known
        rows = np.zeros((len(known), self.jacobian.shape[2]))
        values = np.zeros(len(known))
        for i, k in enumerate(known):
            offset = self.centres[k.second] - self.centres[k.first]
            length = float(np.linalg.norm(offset))
            for socket, sign in ((k.second, 1), (k.first, -1)):
                begin = self.problem.size + 3 * socket
                rows[i, begin : begin + 3] = sign * offset / length
            values[i] = length - k.distance
        return self.whiten @ rows, self.whiten @ values

    def update_groups(self) -> float:
        """Take one step for the widths; return the largest relative change of those that matter."""
        covariance = np.zeros((len(self.free),) * 2)
        covariance[np.ix_(self.free, self.free)] = self.covariance
        updated: list[Group] = []
        change = 0.0
        for group in self.groups:
            new = group
            if group.learned:
                members = group.members[~self.fixed[group.members]]
                new = group.updated(self.x[members], covariance[np.ix_(members, members)], members)
                if self.effect(new) > NEGLIGIBLE:
                    change = max(change, abs(log(new.width / group.width)))
            updated.append(new)
        self.groups = tuple(updated)
        return change

    def update_noise(self, inverse: Vector, step: Vector) -> float:
        """Take one step for s_x^2 and s_q^2; return the relative change."""
        J = self.jacobian_before[:, :, self.free]
        leverage = (J @ self.covariance) @ J.transpose(0, 2, 1)
        leverage *= INFORMATION * self.weights[:, None, None]
        errors = self.residuals_before + self.jacobian_before @ step
        before, matters = self.noise, self.joint_effect() > NEGLIGIBLE
        squares = before.fisher_step(inverse, self.weights, errors, leverage, self.by_joints_before)
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
        return _inverse(self.hessian - self.prior_precision() + self.prior_precision(widened=True))

    def log_evidence(self, squares: Vector) -> float:
        """Return the logarithm of the evidence, by Laplace's approximation."""
        N = len(squares)
        scales = np.linalg.slogdet(self.noise.scales(self.by_joints))[1]
        constant = lgamma((NU + 3) / 2) - lgamma(NU / 2) - 1.5 * log(NU * pi)
        value = N * constant - 0.5 * scales.sum() - 0.5 * (NU + 3) * np.log1p(squares / NU).sum()
        value += float(self.volume[: self.problem.size] @ self.x)
        value -= 0.5 * float(np.sum(self.distance_rows()[1] ** 2))
        for group, members in self.priors():
            P = group.precision(members, group.width)
            value += 0.5 * float(np.linalg.slogdet(P)[1] - self.x[members] @ P @ self.x[members])
            value -= 0.5 * (group.width / group.scale) ** 2
        return float(value - 0.5 * np.linalg.slogdet(self.hessian)[1])


def _inverse(H: Vector) -> Vector:
    """Return the inverse of a positive definite matrix whose rows differ in scale."""
    scale = 1 / np.sqrt(np.diag(H))
    return np.linalg.inv(H * scale[:, None] * scale) * scale[:, None] * scale

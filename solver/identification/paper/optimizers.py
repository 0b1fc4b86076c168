"""Gauss-Newton, and the paper's IPOPT; both stop by the paper's rule, a least relative change."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ....errors import NotConverged

TOLERANCE = 1e-8
"""Relative change of the objective at which both stop."""
MAX_ITERATIONS = 200


@dataclass(frozen=True)
class Solution:
    """The minimum, and the way to it."""

    iterates: tuple[np.ndarray, ...]
    """Every accepted point, from the start to the end."""

    @property
    def x(self) -> np.ndarray:
        """The minimum."""
        return self.iterates[-1]


def gauss_newton(
    evaluate: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    start: np.ndarray,
    *,
    max_iterations: int = MAX_ITERATIONS,
) -> Solution:
    """Minimise |r(x)|^2 by Gauss-Newton steps, damped after Levenberg and Marquardt."""
    # Calibration is nearly linear: damping starts near zero, and grows only when a step fails.
    x = np.array(start, dtype=float)
    residuals, jacobian = evaluate(x)
    cost = float(residuals @ residuals)
    iterates = [x]
    damping = 1e-14
    while len(iterates) <= max_iterations:
        step, promised = _damped_step(residuals, jacobian, damping)
        # A full step that promises nothing beyond rounding: this is the minimum.
        if damping < 1e-8 and promised <= TOLERANCE * 1e-2 * cost:
            return Solution(tuple(iterates))
        new_residuals, new_jacobian = evaluate(x + step)
        new_cost = float(new_residuals @ new_residuals)
        if not new_cost < cost:  # NaN included
            damping = max(damping, 1e-9) * 10
            if damping > 1e12:
                raise NotConverged(
                    "gauss-newton found no way down; check the model and the data"
                )
            continue
        change = cost - new_cost
        x = x + step
        residuals = new_residuals
        jacobian = new_jacobian
        cost = new_cost
        iterates.append(x)
        damping = max(damping / 10, 1e-14)
        if change <= TOLERANCE * cost:
            return Solution(tuple(iterates))
    raise NotConverged(f"gauss-newton did not converge in {max_iterations} iterations")


def _damped_step(
    residuals: np.ndarray,
    jacobian: np.ndarray,
    damping: float,
) -> tuple[np.ndarray, float]:
    """Return the step, and by how much the objective should fall if the residuals were linear."""
    H = jacobian.T @ jacobian
    gradient = jacobian.T @ residuals
    idle = np.diag(H) == 0  # a parameter without any effect stays where it is
    damped = H + np.diag(np.where(idle, 1.0, damping * np.diag(H)))
    step = -np.linalg.solve(damped, gradient)
    return step, float(-step @ (2 * gradient + H @ step))


def ipopt(
    objective: Callable[[Any], Any],
    start: np.ndarray,
    *,
    max_iterations: int = MAX_ITERATIONS,
) -> Solution:
    """Minimise a CasADi expression with IPOPT and its exact Hessian."""
    x = ca.MX.sym("x", len(start))
    monitor = _Monitor(len(start))
    solver = ca.nlpsol(
        "calibration",
        "ipopt",
        # In square millimetres, so that IPOPT's own absolute tolerances are far below the noise.
        {"x": x, "f": 1e6 * objective(x)},
        {
            "print_time": False,
            "iteration_callback": monitor,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "max_iter": max_iterations,
                "tol": 1e-12,
            },
        },
    )
    result: np.ndarray = solver(x0=start)["x"].full().ravel()
    status: str = solver.stats()["return_status"]
    if not monitor.converged and status not in (
        "Solve_Succeeded",
        "Solved_To_Acceptable_Level",
    ):
        raise NotConverged(
            f"ipopt did not converge: {status.replace('_', ' ').lower()}"
        )
    iterates = monitor.iterates if monitor.converged else [*monitor.iterates, result]
    return Solution(tuple(iterates))


class _Monitor(ca.Callback):
    """Callback of IPOPT: notes each iterate, and stops by the paper's rule."""

    def __init__(self, size: int) -> None:
        ca.Callback.__init__(self)
        self.size = size
        self.iterates: list[np.ndarray] = []
        self.objective = np.inf
        self.converged = False
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(ca.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> Any:
        name = ca.nlpsol_out(i)
        size = {"x": self.size, "lam_x": self.size, "f": 1}.get(name, 0)
        return ca.Sparsity.dense(size, 1)

    def eval(self, arg: Any) -> list[int]:
        x: np.ndarray = arg[0].full().ravel()
        objective = float(arg[1])
        change = self.objective - objective
        self.iterates.append(x)
        self.objective = objective
        self.converged = 0 <= change <= TOLERANCE * abs(objective)
        return [int(self.converged)]

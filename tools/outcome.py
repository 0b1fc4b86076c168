"""From measurements to a calibration with all its figures, by either method."""

import hashlib
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from ..solver.calibrated import Calibration
from ..solver.data.measurements import Measurement
from ..solver.data.metrics import CALIPER_DEVIATION, evaluate, is_distorted
from ..solver.data.observations import KnownDistance, Load, observe
from ..solver.paper.problem import build_problem, calibrate, refit_ball
from ..solver.result import figures, history, models_of
from ..solver.robot.parameters import Parameter
from ..solver.robot.urdf import Robot

if TYPE_CHECKING:
    from ..solver.auto.posterior import Posterior

__all__ = ["AutoSettings", "Outcome", "calibrate_by_auto", "calibrate_by_paper", "provenance"]


@dataclass(frozen=True)
class Outcome:
    """A calibration, and what is said of it."""

    calibration: Calibration
    result: dict[str, Any]
    """Machine-readable, SI units; see the command line's contract."""
    weights: dict[str, list[float]] = field(default_factory=dict[str, list[float]])
    """Robust weight of each sample of the training placements, by placement, 1 and less."""

    @property
    def distorted(self) -> list[str]:
        """Training placements whose distance between sockets the model does not reproduce."""
        return self.result["distorted"]


@dataclass(frozen=True)
class AutoSettings:
    """What ``--method auto`` may be told."""

    known: tuple[KnownDistance, ...] = ()
    """Measured distances beside those between each placement's first two sockets."""
    deviation: float = CALIPER_DEVIATION
    """Standard deviation of the latter [m]."""
    load: Load = field(default_factory=Load)
    without: tuple[str, ...] = ()
    """Among ``compliance``, ``transmission`` and ``joint-noise``: what is not to be tried."""


def calibrate_by_paper(
    robot: Robot,
    parameters: Sequence[Parameter],
    train: Sequence[Measurement],
    test: Sequence[Measurement],
    *,
    optimizer: str,
    regularization: float,
    max_iterations: int,
) -> Outcome:
    """Calibrate by Eq. (5) of the paper.

    Raises:
        NotConverged: The optimizer gave up.
    """
    problem = build_problem(robot, train, parameters=parameters, regularization=regularization)
    fit = calibrate(problem, optimizer, max_iterations)
    calibration = Calibration(robot, problem.parameters, fit.x)
    iterates = [partial(_paper_points, problem.model, x) for x in fit.solution.iterates]
    return Outcome(
        calibration,
        {
            "method": "paper",
            "optimizer": fit.optimizer,
            "iterations": fit.solution.iterations,
            "converged": True,
            "solve_seconds": fit.seconds,
            **_common(calibration, train, test, regularization),
            "history": history(iterates, train, test),
        },
    )


def _paper_points(model: Any, x: Any, measured: Measurement) -> Any:
    return model.points(x, measured.positions)


def _common(
    calibration: Calibration,
    train: Sequence[Measurement],
    test: Sequence[Measurement],
    regularization: float = 1e-4,
) -> dict[str, Any]:
    """Return what both methods say alike: figures, distortion, parameters."""
    paired = [measured for measured in train if measured.has_distance]
    robot = calibration.robot
    refitted = (
        refit_ball(build_problem(robot, paired, regularization=regularization)) if paired else None
    )
    return {
        **figures(models_of(calibration, refitted), train, test),
        "distorted": [
            m.name
            for m in train
            if is_distorted(evaluate(calibration.ball(m.positions, m.efforts), m), m)
        ],
        "parameters": calibration.table(),
    }


def calibrate_by_auto(
    robot: Robot,
    parameters: Sequence[Parameter],
    train: Sequence[Measurement],
    test: Sequence[Measurement],
    settings: AutoSettings,
    progress: Callable[[str], None] = lambda _: None,
) -> Outcome:
    """Calibrate geometry, joint compliance and transmission error, as far as the data support.

    Raises:
        NotConverged: A fit did not settle.
        KnownError: A known distance does not fit the placements.
    """
    import time

    from ..solver.auto.selection import STAGES, calibrate_auto

    begin = time.perf_counter()
    data = observe(
        train, robot, known=settings.known, deviation=settings.deviation, load=settings.load
    )
    fit = calibrate_auto(
        robot,
        parameters,
        data,
        stages=[name for name in STAGES if name not in settings.without],
        joint_noise="joint-noise" not in settings.without,
        progress=progress,
    )
    seconds = time.perf_counter() - begin
    full = fit.full
    calibration = Calibration(
        robot,
        tuple(parameters),
        full.values,
        full.deflection,
        settings.load,
        fit.geometric.values if full.model.extensions else None,
    )
    load = settings.load

    def points(x: Any, m: Measurement) -> Any:
        return full.model.predict(x, m.positions, load.torques(robot, m))

    outcome = Outcome(
        calibration,
        {
            "method": "auto",
            "optimizer": "gauss-newton",
            "iterations": len(full.iterates) - 1,
            "converged": True,
            "solve_seconds": seconds,
            **_common(calibration, train, test),
            **_uncertainty(calibration, full),
            "choices": list(fit.notes),
            "history": history([partial(points, x) for x in full.iterates], train, test),
        },
        _weights(train, full),
    )
    for row, m in zip(outcome.result["placements"], (*train, *test), strict=True):
        row.update(_spread(calibration, full, m))
    return outcome


def _weights(train: Sequence[Measurement], full: "Posterior") -> dict[str, list[float]]:
    """Return each training placement's robust weights, in the order of its samples."""
    weights: dict[str, list[float]] = {}
    rest = full.weights.tolist()
    for measured in train:
        queues: dict[int, Iterator[float]] = {}
        for socket, count in zip(measured.sockets, measured.counts, strict=True):
            queues[socket], rest = iter(rest[:count]), rest[count:]
        weights[measured.name] = [next(queues[s.socket]) for s in measured.placement.samples]
    return weights


def _uncertainty(
    calibration: Calibration,
    full: "Posterior",
) -> dict[str, Any]:
    """Return groups, noise, deviations, and what the data cannot identify."""
    from ..solver.auto import uncertainty as u
    from ..solver.auto.directions import CANNOT_SEE, weak_directions

    deviation = u.deviations(full)
    names = full.model.names
    n = full.model.geometry
    coefficients = [
        {
            "name": name,
            "unit": "rad/(N m)" if name.endswith("compliance") else "rad",
            "value": float(value),
            "standard_deviation": float(d),
        }
        for name, value, d in zip(names[n:], full.x[n:], deviation[n:], strict=True)
    ]
    return {
        "parameters": [
            {**row, "standard_deviation": float(d)}
            for row, d in zip(calibration.table(), deviation[:n], strict=True)
        ],
        "coefficients": coefficients,
        "groups": [
            {
                "name": group.name,
                "unit": group.unit,
                "count": len(group.members),
                "width": group.width,
                "effective": group.effective,
                "active": group.width > 0,
            }
            for group in full.groups
        ],
        "noise": {"space": full.noise.space, "joint": full.noise.joint, "nu": 5.0},
        "log_evidence": full.log_evidence,
        "uncertainty": {
            "weak_directions": [
                {"text": d.text, "deviation": d.deviation} for d in weak_directions(full)
            ],
            "correlations": [{"a": a, "b": b, "value": r} for a, b, r in u.correlations(full)],
            "observability_index": u.observability_index(full),
            "distance_deviation": u.workspace_deviation(full, calibration.load),
            "cannot_see": list(CANNOT_SEE),
        },
    }


def _spread(calibration: Calibration, full: "Posterior", m: Measurement) -> dict[str, float]:
    """Return the predicted and the found rms distance of a placement's samples from their mean."""
    import numpy as np

    from ..solver.auto.uncertainty import predicted_deviation

    torques = calibration.load.torques(calibration.robot, m)
    points = full.predict(m.positions, torques)
    squares = sum(float(np.sum((points[r] - points[r].mean(axis=0)) ** 2)) for r in m.slices)
    return {
        "predicted_deviation": predicted_deviation(
            full, [(m.positions[rows], torques[rows]) for rows in m.slices]
        ),
        "found_deviation": (squares / len(points)) ** 0.5,
    }


def provenance(robot: Robot, measurements: Sequence[Measurement]) -> dict[str, Any]:
    """Return what a result was made from and with: digests, versions, time."""
    return {
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "model_sha256": robot.sha256,
        "data_sha256": {
            str(file): hashlib.sha256(file.read_bytes()).hexdigest()
            for measured in measurements
            for file in measured.placement.files
        },
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("mukca", "casadi", "numpy", "yourdfpy")},
        },
    }

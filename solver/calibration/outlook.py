"""What more recordings would bring, how well each place is known, and which joint matters."""

import numpy as np

from ..bayes.inference import Posterior
from ..bayes.model import extend
from ..bayes.results import workspace_deviation
from ..data import Load, Measurement
from ..design import error_map, joint_effects, predicted_posterior, workspace_samples
from ..diagnostics import farthest_place
from ..results import Forecast, Outlook
from ..robot import InverseKinematics, Robot, SimulationError
from .fit import Fit
from .problem import CalibrationProblem

GUIDED, ADVISED = 10, 30
"""Configurations in each socket that are thought of, and that are advised: each counts thrice."""
NEARER = (1.0, 0.85, 0.7)
"""A place that the arm does not reach is tried nearer to its base, by these factors."""

Samples = list[tuple[np.ndarray, np.ndarray]]
"""For each socket, joint positions and moments."""


def outlook_of(task: CalibrationProblem, fit: Fit) -> Outlook | None:
    """Return what a calibration will be worth; None where nothing was trained on in sockets."""
    load, calibrated = fit.calibrated.load, fit.calibrated
    train = [m for m in task.train if m.kind == "sockets"]
    if not train:
        return None
    recorded = [pair for m in train for pair in _samples(task.robot, m, load)]
    posterior = fit.posterior
    if posterior is None:
        model = extend(task.robot, calibrated.parameters)
        x = calibrated.values - calibrated.model.nominal
        return Outlook(joints=joint_effects(model, x, workspace_samples(model, x, load), recorded))
    test = [m for m in task.test if m.kind == "sockets"]
    centres = np.array([calibrated.ball(m.positions, m.efforts).mean(axis=0) for m in train + test])
    forecasts = [
        Forecast(
            placement=m.name,
            distance_deviation=_after(posterior, load, _samples(task.robot, m, load)),
        )
        for m in test
    ]
    new = _imagined(task.robot, farthest_place(centres), train[0].distance, load)
    if new:
        forecasts.append(Forecast(placement=None, distance_deviation=_after(posterior, load, new)))
    poses = workspace_samples(posterior.model, posterior.x, load)
    return Outlook(
        joints=joint_effects(posterior.model, posterior.x, poses, recorded),
        map=error_map(posterior, poses),
        forecasts=tuple(forecasts),
    )


def _samples(robot: Robot, measured: Measurement, load: Load) -> Samples:
    moments = load.torques(robot, measured)
    return [(measured.positions[rows], moments[rows]) for rows in measured.slices]


def _after(posterior: Posterior, load: Load, samples: Samples) -> float:
    return workspace_deviation(predicted_posterior(posterior, samples), load)[0]


def _imagined(robot: Robot, place: np.ndarray, distance: float, load: Load) -> Samples:
    """Return varied samples in both sockets of a base at a place; none where it is out of reach."""
    half = np.array([0.0, distance / 2, 0.0])
    for factor in NEARER:
        centre = place * np.array([factor, factor, 1.0])
        balls = np.repeat([centre - half, centre + half], GUIDED, axis=0)
        try:
            q = InverseKinematics(robot).reach(balls, np.random.default_rng(0))
        except SimulationError:
            continue
        repeated = [np.tile(rows, (ADVISED // GUIDED, 1)) for rows in (q[:GUIDED], q[GUIDED:])]
        return [(rows, load.moments(robot, rows, None)) for rows in repeated]
    return []

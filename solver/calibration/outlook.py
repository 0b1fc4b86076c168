"""Outlook of a calibration: errors over the workspace, joint by joint, and after more samples."""

import numpy as np

from .. import results
from .. import studies as bayes
from ..design import error_map, joint_effects, predicted_posterior, workspace_samples
from ..diagnostics import farthest_place
from ..identification.data import Load, Samples
from ..identification.robot import Robot
from ..poses import InverseKinematics, SimulationError

GUIDED, ADVISED = 10, 20
"""Configurations in each socket that are thought of, and that are advised: each counts twice."""
NEARER = (1.0, 0.85, 0.7)
"""A place that the arm does not reach is tried nearer to its base, by these factors."""


def outlook_of(
    fit: results.Fit, problem: results.Measurements
) -> results.Outlook | None:
    """Return what a calibration will be worth; None where nothing was trained on in sockets."""
    robot = problem.robot
    calibrated = fit.calibrated
    load = calibrated.load
    train = [m for m in problem.measurements if m.kind == "sockets"]
    if not train:
        return None
    model, x = bayes.model_of(fit)
    poses = workspace_samples(model, x, load)
    recorded = load.by_socket(robot, *train)
    joints = joint_effects(model, x, poses, recorded)
    if fit.posterior is None:
        return results.Outlook(joints=joints)
    test = [m for m in problem.test if m.kind == "sockets"]
    centres = np.array(
        [calibrated.ball(m.positions, m.efforts).mean(axis=0) for m in train + test]
    )
    new = samples_on_base(robot, farthest_place(centres), train[0].distance, load)
    exported = calibrated.exported
    now = bayes.workspace_errors(fit.posterior, load, exported)
    forecasts: list[results.Forecast] = []
    for name, samples in [
        *((m.name, load.by_socket(robot, m)) for m in test),
        (None, new),
    ]:
        if not samples:
            continue
        posterior = predicted_posterior(fit.posterior, samples)
        after = bayes.workspace_errors(posterior, load, exported)
        forecast = results.Forecast(
            placement=name,
            distance_deviation=after.median,
            share=(after.alone or after.median) / (now.alone or now.median),
        )
        forecasts.append(forecast)
    places = error_map(fit.posterior, poses)
    return results.Outlook(joints=joints, map=places, forecasts=tuple(forecasts))


def samples_on_base(
    robot: Robot, place: np.ndarray, distance: float, load: Load
) -> list[Samples]:
    """Return varied samples in both sockets of a base at a place; none where it is out of reach."""
    half = np.array([0.0, distance / 2, 0.0])
    for factor in NEARER:
        centre = place * np.array([factor, factor, 1.0])
        balls = np.repeat([centre - half, centre + half], GUIDED, axis=0)
        try:
            q = InverseKinematics(robot).reach(balls, np.random.default_rng(0))
        except SimulationError:
            continue
        repeated = [
            np.tile(rows, (ADVISED // GUIDED, 1)) for rows in (q[:GUIDED], q[GUIDED:])
        ]
        return [load.at(robot, rows) for rows in repeated]
    return []


OUTLOOK = results.Study("outlook", outlook_of, needs_posterior=False)

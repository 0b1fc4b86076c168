"""Estimates of a fit: parameters, their uncertainty and their use."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import results
from ..bayes import results as bayes
from ..bayes.inference import Posterior
from ..bayes.model import extend
from ..data import Load, Measurement
from ..design import error_map, joint_effects, predicted_posterior, workspace_samples
from ..diagnostics import farthest_place
from ..robot import InverseKinematics, Robot, SimulationError
from .fit import Fit
from .problem import CalibrationProblem

GUIDED, ADVISED = 10, 30
"""Configurations in each socket that are thought of, and that are advised: each counts thrice."""
NEARER = (1.0, 0.85, 0.7)
"""A place that the arm does not reach is tried nearer to its base, by these factors."""

BySocket = list[tuple[np.ndarray, np.ndarray]]
"""For each socket, joint positions and moments."""


def parameter_values(
    calibrated: results.CalibratedRobot, posterior: Posterior | None = None
) -> tuple[results.ParameterValue, ...]:
    """Return every calibrated number of the joint origins, with its deviation where known."""
    columns = (calibrated.model.nominal, calibrated.values, calibrated.geometry)
    known: list[Any] = [None] * len(calibrated.values)
    if posterior is not None:
        known = bayes.deviations(posterior).tolist()
    rows = zip(calibrated.parameters, *(c.tolist() for c in columns), known, strict=False)
    return tuple(
        results.ParameterValue.filled(
            p, nominal=a, calibrated=b, change=b - a, exported=c, standard_deviation=deviation
        )
        for p, a, b, c, deviation in rows
    )


def error_curves(posterior: Posterior) -> results.ErrorCurves | None:
    """Return the error curves of the joints that turn, with their deviations; None for none."""
    curves = posterior.deflection.curves
    if curves is None:
        return None
    model, group = posterior.model, posterior.groups[-1]
    assert group.length is not None
    (knots, m), own = curves.shape, model.slices[-1]
    weights = np.array([1, 4, 1]) / 6
    near = np.arange(-1, 2, dtype=np.int64)[:, None] + np.arange(knots, dtype=np.int64)
    near %= knots
    joints: list[results.JointCurve] = []
    for k, joint in enumerate(model.robot.actuated):
        if joint.type == "prismatic":
            continue
        sigma = posterior.covariance[own, own][k::m, k::m]
        variances = np.einsum("i,j,ijk->k", weights, weights, sigma[near[:, None], near])
        joints.append(
            results.JointCurve(
                joint=joint.name,
                values=_rounded(weights @ curves[near, k]),
                deviations=_rounded(np.sqrt(variances.clip(min=0))),
                sampled=results.sampled_ranges(posterior.data.positions[:, k], group.length),
            )
        )
    return results.ErrorCurves(amplitude=group.width, length=group.length, joints=tuple(joints))


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    """Return angles to a nanoradian, so that a file is not full of digits."""
    return tuple(np.round(values, 9).tolist())


def known_of(
    posterior: Posterior, calibrated: results.CalibratedRobot, recorded: Sequence[Measurement]
) -> dict[str, Any]:
    """Return by key how well everything is known, here and there, and what the data decided."""
    model, load, exported = posterior.model, calibrated.load, calibrated.exported
    columns = (model.names, model.units, posterior.x.tolist(), bayes.deviations(posterior).tolist())
    beyond = list(zip(*columns, strict=True))[model.geometry : model.scalars]  # none of the curves
    measured, turns = (posterior.noises.get(kind) for kind in ("points", "turns"))
    weak = bayes.weakly_identifiable_directions(posterior)
    return {
        "coefficients": tuple(
            results.Coefficient(name=name, unit=unit, value=value, standard_deviation=deviation)
            for name, unit, value, deviation in beyond
        ),
        "curves": error_curves(posterior),
        "groups": tuple(
            results.PriorWidth.filled(
                group,
                count=len(group.members),
                effective=bayes.effective_parameters(posterior, group),
                active=group.width > 0,
            )
            for group in posterior.groups
        ),
        "noise": results.NoiseScale.filled(
            posterior.noise,
            measured_space=measured and measured.space,
            measured_joint=measured and measured.joint,
            measured_turn=turns and turns.space,
        ),
        "log_evidence": posterior.log_evidence,
        "uncertainty": results.Uncertainty(
            weak_directions=weak,
            correlations=bayes.correlations(posterior),
            observability_index=bayes.observability_index(posterior),
            distance_deviation=bayes.workspace_errors(posterior, load, exported),
            near=bayes.errors_near(posterior, load, [m.positions for m in recorded], exported),
            cannot_see=bayes.unobservable(posterior, weak),
        ),
    }


def scale_of(fit: Fit) -> results.Scale:
    """Return by how much the arm came out larger than its model."""
    if fit.posterior is not None:
        return bayes.scale(fit.posterior)
    calibrated = fit.calibrated
    by_scale = extend(calibrated.robot, calibrated.parameters).by_scale()
    value = float(by_scale @ (calibrated.values - calibrated.model.nominal))
    if fit.covariance is None:
        return results.Scale(value=value)
    return results.Scale(value=value, deviation=float(by_scale @ fit.covariance @ by_scale) ** 0.5)


def outlook_of(problem: CalibrationProblem, fit: Fit) -> results.Outlook | None:
    """Return what a calibration will be worth; None where nothing was trained on in sockets."""
    robot, calibrated, load = problem.robot, fit.calibrated, fit.calibrated.load
    train = [m for m in problem.measurements if m.kind == "sockets"]
    if not train:
        return None
    if fit.posterior is None:
        model = extend(robot, calibrated.parameters)
        x = calibrated.values - calibrated.model.nominal
    else:
        model, x = fit.posterior.model, fit.posterior.x
    poses = workspace_samples(model, x, load)
    recorded = [pair for m in train for pair in load.by_socket(robot, m)]
    joints = joint_effects(model, x, poses, recorded)
    if fit.posterior is None:
        return results.Outlook(joints=joints)
    test = [m for m in problem.test if m.kind == "sockets"]
    centres = np.array([calibrated.ball(m.positions, m.efforts).mean(axis=0) for m in train + test])
    new = _imagined(robot, farthest_place(centres), train[0].distance, load)
    further = [*((m.name, load.by_socket(robot, m)) for m in test), (None, new)]
    forecasts = tuple(
        results.Forecast(
            placement=name, distance_deviation=bayes.workspace_errors(after, load).median
        )
        for name, samples in further
        if samples and (after := predicted_posterior(fit.posterior, samples))
    )
    return results.Outlook(joints=joints, map=error_map(fit.posterior, poses), forecasts=forecasts)


def _imagined(robot: Robot, place: np.ndarray, distance: float, load: Load) -> BySocket:
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

"""Errors of a calibration and of the models beside it: by placement, role and iteration."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..bayes.inference import Posterior
from ..bayes.results import length_deviation, predicted_deviation
from ..data import (
    CALIPER_DEVIATION,
    Measurement,
    Metrics,
    Pose,
    cost_terms,
    evaluate,
    fit_frames,
    fit_pose,
    found_deviation,
    mean_metrics,
    removed_share,
)
from ..paper import ball_only, build_problem, solve
from ..results import (
    CalibratedRobot,
    CostTerms,
    Iteration,
    PlacementErrors,
    Role,
    Summaries,
    Summary,
)
from ..robot import BallModel, Robot, all_parameters
from .fit import Predict

BALL_STEPS = 6
"""Gauss-Newton steps for the ball's place alone; the problem is nearly linear."""


def placement_errors(
    models: Mapping[str, Predict],
    role: Role,
    measured: Measurement,
    posterior: Posterior | None = None,
    calibrated: CalibratedRobot | None = None,
    frames: Mapping[str, Mapping[str, Pose]] | None = None,
) -> PlacementErrors:
    """Return how far off a placement is by each model.

    Args:
        models: What to compare, by the names of :class:`PlacementErrors`.
        role: ``train`` or ``test``.
        measured: The placement.
        posterior: How well the calibrated model is known, where that is known.
        calibrated: That model.
        frames: Where each model has the instruments' frames, see :func:`frames_of`.
    """
    predicted = actual = length = None
    if posterior is not None and calibrated is not None:
        predicted, actual, length = _deviations(calibrated, posterior, measured)
    metrics = {
        name: evaluate(predict(measured), measured, (frames or {}).get(name))
        for name, predict in models.items()
    }
    return PlacementErrors(
        name=measured.name,
        role=role,
        kind=measured.kind,
        samples=measured.counts,
        distance=measured.distance if measured.kind == "sockets" else None,
        distance_source=measured.distance_source if measured.kind == "sockets" else None,
        nominal=metrics["nominal"],
        calibrated=metrics["calibrated"],
        geometric=metrics.get("geometric"),
        ball_refitted=metrics.get("ball_refitted"),
        predicted_deviation=predicted,
        found_deviation=actual,
        distance_deviation=length if role == "test" else None,
    )


def _deviations(
    calibrated: CalibratedRobot, posterior: Posterior, measured: Measurement
) -> tuple[float, float, float | None]:
    """Return the predicted and the found rms distance of samples from their socket's mean [m].

    The last is the deviation of the distance error [m], where there is one.
    """
    torques = calibrated.load.torques(calibrated.robot, measured)
    by_socket = [(measured.positions[rows], torques[rows]) for rows in measured.slices]
    points = calibrated.ball(measured.positions, measured.efforts)
    if measured.kind == "points" and posterior.measured_noise is not None:
        posterior = replace(posterior, noise=posterior.measured_noise)
    length = None
    if measured.has_distance:
        known = measured.distance_deviation or CALIPER_DEVIATION
        length = length_deviation(posterior, by_socket, known)
    return predicted_deviation(posterior, by_socket), found_deviation(points, measured), length


def summarise(placements: Sequence[PlacementErrors]) -> Summaries:
    """Return the means over the placements of each role."""
    by_role = {r: [p for p in placements if p.role == r] for r in ("train", "test")}
    train, test = (_summary(rows) if rows else None for rows in by_role.values())
    return Summaries(train=train, test=test)


def _summary(rows: Sequence[PlacementErrors]) -> Summary:
    nominal = mean_metrics([row.nominal for row in rows])
    calibrated = mean_metrics([row.calibrated for row in rows])
    return Summary(
        nominal=nominal,
        calibrated=calibrated,
        geometric=_mean([row.geometric for row in rows]),
        ball_refitted=_mean([row.ball_refitted for row in rows]),
        removed_error=removed_share(nominal, calibrated),
    )


def _mean(metrics: Sequence[Metrics | None]) -> Metrics | None:
    there = [m for m in metrics if m is not None]
    return mean_metrics(there) if there else None


def history(
    iterates: Sequence[Predict], train: Sequence[Measurement], test: Sequence[Measurement]
) -> tuple[Iteration, ...]:
    """Return inconsistency and distortion [m^2] after each iteration, the nominal model first."""
    return tuple(
        Iteration(iteration=i, train=_cost(predict, train), test=_cost(predict, test))
        for i, predict in enumerate(iterates)
    )


def _cost(predict: Predict, placements: Sequence[Measurement]) -> CostTerms | None:
    if not placements:
        return None
    pairs = [cost_terms(predict(m), m) for m in placements]
    inconsistency, distortion = np.mean(pairs, axis=0).tolist()
    return CostTerms(inconsistency=inconsistency, distortion=distortion)


def models_of(calibrated: CalibratedRobot) -> dict[str, Predict]:
    """Return the models to compare: name, and how each predicts the balls of a placement.

    Nominal, calibrated, and the exported geometry where it differs.
    """
    models: dict[str, Predict] = {
        "nominal": lambda m: calibrated.nominal_ball(m.positions),
        "calibrated": lambda m: calibrated.ball(m.positions, m.efforts),
    }
    if calibrated.exported is not None:
        models["geometric"] = lambda m: calibrated.geometric_ball(m.positions)
    return models


def ball_refitted(
    robot: Robot, train: Sequence[Measurement], regularization: float
) -> dict[str, Predict]:
    """Return the nominal model with only the ball's place fitted; nothing where none tells it."""
    paired = [measured for measured in train if measured.has_distance]
    measured = [m for m in train if m.kind == "points"]
    if not paired and measured:
        return {"ball_refitted": _ball_by_points(robot, measured)}
    if not paired:
        return {}
    problem = ball_only(build_problem(robot, paired, regularization=regularization))
    x = solve(problem).x
    return {"ball_refitted": lambda m: problem.model.points(x, m.positions)}


def _ball_by_points(robot: Robot, train: Sequence[Measurement]) -> Predict:
    """Return the nominal model with the ball's place fitted to measured points.

    Gauss-Newton for the ball's place and for the pose of each frame, which follows from the place.
    """
    free = [p.index for p in all_parameters(robot) if p.of_ball and p.unit == "m"]
    model = BallModel(robot, free)
    x = model.nominal.copy()
    by_frame: dict[str, list[Measurement]] = {}
    for m in train:
        by_frame.setdefault(m.frame, []).append(m)
    for _ in range(BALL_STEPS):
        rows: list[np.ndarray] = []
        off: list[np.ndarray] = []
        for group in by_frame.values():
            linear = model.linearise(x, np.concatenate([m.positions for m in group]))
            measured = np.concatenate([m.points for m in group])
            pose = fit_pose(measured, linear.points)
            slopes = pose.slopes(measured).reshape(-1, 6)
            by_ball = linear.by_parameters.reshape(-1, len(free))
            rows.append(by_ball - slopes @ np.linalg.lstsq(slopes, by_ball, rcond=None)[0])
            off.append((linear.points - pose.apply(measured)).ravel())
        x -= np.linalg.lstsq(np.concatenate(rows), np.concatenate(off), rcond=None)[0]
    return lambda m: model.points(x, m.positions)


def frames_of(
    models: Mapping[str, Predict], train: Sequence[Measurement]
) -> dict[str, dict[str, Pose]]:
    """Return where each model has the frames in which points trained on were measured."""
    measured = [m for m in train if m.kind == "points"]
    return {name: fit_frames([(p(m), m) for m in measured]) for name, p in models.items()}

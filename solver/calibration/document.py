"""Document of a calibration: a fit and its figures, as ``calibration.json`` holds them.

:mod:`.earlier` reads the posterior back.
"""

import base64
import platform
import zlib
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime, timezone
from itertools import chain, islice, repeat
from typing import Any

import casadi as ca
import numpy as np

from ..._version import __version__
from .. import results
from ..identification.data import Measurement, as_point, is_distorted
from ..identification.inference import FitPosterior, Posterior
from ..identification.model import PriorGroup, submatrix
from ..identification.robot import Robot
from .errors import Errors, history, left_out_errors, placement_errors
from .fit import CalibrationProblem, ball_refitted

UNKNOWN = (
    "how well the calibration is known could not be computed: the samples are too few or too much "
    "alike; record more that differ"
)


def document_of(
    problem: CalibrationProblem, fit: results.Fit, studies: Sequence[results.Study]
) -> results.CalibrationDocument:
    """Return all that is to be kept of a calibration; nothing is written yet."""
    if fit.full is not None:
        shifts = fit.posterior and fit.posterior.moved
        problem = problem.at_rest(shifts, fit.calibrated)
    return results.studied(_fitted(problem, fit), fit, problem, studies)


def _fitted(
    problem: CalibrationProblem, fit: results.Fit
) -> results.CalibrationDocument:
    """Return a fit and the errors of its model, before any study."""
    calibrated, full, robot = fit.calibrated, fit.full, problem.robot
    ball = ball_refitted(problem)
    rows = placement_errors(calibrated, ball, problem.measurements, problem.placements)
    left_out = left_out_errors(problem.folds)
    errors = Errors([*rows, *left_out])
    is_unknown = full is not None and fit.posterior is None
    model = results.FoldModel.of(calibrated, ball)
    return results.CalibrationDocument(
        format=results.FORMAT,
        robot=robot.source,
        method=problem.options.method,
        optimizer=fit.optimizer,
        iterations=len(fit.iterates) - 1,
        converged=True,
        solve_seconds=fit.seconds,
        placements=errors.placements,
        summary=errors.summary,
        left_out=tuple(left_out),
        distorted=tuple(
            m.name
            for m in problem.measurements
            if is_distorted(calibrated.predict(m), m)
        ),
        rotation_numbers=calibrated.rotation_numbers,
        choices=full and full.notes,
        history=history(fit.iterates, problem.measurements, problem.test),
        settings={**robot.loaded_with, **problem.options.as_dict()},
        provenance=_provenance(robot, [m for _, m in problem.placements]),
        checks=problem.checks,
        hypotheses=problem.hypotheses,
        next_placement=problem.next_placement,
        warnings=(*problem.warnings, *([UNKNOWN] if is_unknown else ())),
        outputs={},
        model=results.Model.filled(
            robot,
            nominal_urdf=robot.text.data.decode(),
            calibrated_urdf=calibrated.urdf().decode(),
        ),
        deflection=model.deflection,
        load=calibrated.load,
        refitted_ball=ball,
        folds=tuple(
            results.FoldModel.of(fold.fit.calibrated, fold.ball)
            for fold in problem.folds
        ),
        data=tuple(_samples(problem, fit.posterior)),
        **_estimates(fit, problem),
    )


def _estimates(fit: results.Fit, problem: CalibrationProblem) -> dict[str, Any]:
    """Return the sections of parameters and, where there is one, of the posterior."""
    posterior, full = fit.posterior, fit.full
    if posterior is None or full is None:
        return {"parameters": _parameters(fit.calibrated, repeat(None))}
    model = posterior.model
    deviations = np.sqrt(np.diag(posterior.covariance)).tolist()
    columns = zip(
        model.names, model.units, posterior.x.tolist(), deviations, strict=False
    )
    points, turns = map(posterior.noises.get, ("points", "turns"))
    return {
        "parameters": _parameters(fit.calibrated, deviations),
        "coefficients": tuple(
            results.Coefficient(name=name, unit=unit, value=x, standard_deviation=s)
            for name, unit, x, s in islice(columns, model.geometry, model.scalars)
        ),
        "groups": tuple(
            results.PriorWidth.filled(
                group,
                count=len(group.members),
                effective=_effective(posterior, group),
                active=group.width > 0,
            )
            for group in posterior.groups
        ),
        "noise": results.NoiseScale.filled(
            posterior.noise,
            measured_space=points and points.space,
            measured_joint=points and points.joint,
            measured_turn=turns and turns.space,
        ),
        "log_evidence": posterior.log_evidence,
        "posterior": _stored(full, problem, alone=fit.frames is None),
    }


def _parameters(
    calibrated: results.CalibratedRobot, deviations: Iterable[float | None]
) -> tuple[results.ParameterValue, ...]:
    """Return every calibrated number of the joint origins, with its standard deviation."""
    numbers = calibrated.model.nominal, calibrated.values, calibrated.geometry
    columns = map(np.ndarray.tolist, numbers)
    return tuple(
        results.ParameterValue.filled(
            parameter,
            nominal=nominal,
            calibrated=value,
            change=value - nominal,
            exported=exported,
            standard_deviation=deviation,
        )
        for parameter, nominal, value, exported, deviation in zip(
            calibrated.parameters, *columns, deviations, strict=False
        )
    )


def _effective(posterior: Posterior, group: PriorGroup) -> float:
    """Return gamma: how many of a group's unknowns the data decide.

    Without one by the estimation, it is the sum of 1 - s^2 / s_prior^2 of the unknowns.
    """
    if group.learned:
        return group.effective
    before = np.diag(group.covariance(group.deviation))
    after = np.diag(posterior.covariance)[group.members]
    is_free = before > 0
    decided_shares = 1 - after[is_free] / before[is_free]
    return max(float(decided_shares.sum()), 0.0)


def _stored(
    posterior: FitPosterior, problem: CalibrationProblem, *, alone: bool
) -> results.StoredPosterior | None:
    """Return what a robot's file keeps of a posterior: of its unknowns, frames, and sockets.

    Of several robots no frame is kept; None where an instrument measured in one.
    """
    if not alone and (posterior.data.sockets < 0).any():
        return None
    arm = posterior.arm
    covariance = posterior.covariance if alone else arm.covariance
    first = len(covariance) - arm.centres.size
    labels = chain.from_iterable(m.labels for m in problem.measurements)
    sockets = [arm.data.labels.index(name) for name in labels]
    of_centres = np.arange(first, len(covariance)).reshape(-1, 3)[sockets].ravel()
    # none of the curves
    rows = np.r_[: arm.model.scalars, arm.model.size : first, of_centres]
    matrix = submatrix(covariance, rows)
    triangle = matrix[np.tril_indices(len(matrix))].astype("<f8")
    return results.StoredPosterior(
        covariance=base64.b64encode(zlib.compress(triangle.tobytes())).decode(),
        noises={kind: (n.space, n.joint, n.nu) for kind, n in arm.noises.items()},
        centres=tuple(map(as_point, arm.centres[sockets])),
    )


def _samples(
    problem: CalibrationProblem, posterior: Posterior | None
) -> Iterator[results.PlacementSamples]:
    """Yield all samples; those trained on have robust weights, which come socket by socket."""
    of_balls = of_turns = repeat(None)
    if posterior is not None:
        turned = posterior.data.turned
        of_balls = chain(posterior.weights[~turned].tolist(), of_balls)
        of_turns = chain(posterior.weights[turned].tolist(), of_turns)
    folds: dict[int, int] = {}
    for number, fold in enumerate(problem.folds):
        for measured in fold.left_out:
            folds |= dict.fromkeys(map(id, measured.placement.samples), number)
    for role, measured in problem.placements:
        placement = measured.placement
        none = [None] * len(placement.samples)
        weights = np.array([*islice(of_balls, len(none))])
        of_turn = [*islice(of_turns, len(none))] if measured.has_orientations else none
        shifts = none
        if measured.moved is not None:
            shifts = map(as_point, measured.as_recorded(measured.moved))
        of_ball = measured.as_recorded(weights).tolist()
        rows = zip(placement.samples, of_ball, of_turn, shifts, strict=True)
        yield results.PlacementSamples.filled(
            placement,
            role=role,
            distance=measured.distance,
            files=tuple(map(str, placement.files)),
            samples=tuple(
                results.RecordedSample.filled(
                    sample,
                    weight=weight,
                    orientation_weight=turn_weight,
                    moved=shift,
                    fold=folds.get(id(sample)),
                )
                for sample, weight, turn_weight, shift in rows
            ),
        )


def _provenance(
    robot: Robot, measurements: Sequence[Measurement]
) -> results.Provenance:
    """Return what a result was made from and with: digests, versions, time."""
    files = chain.from_iterable(measured.placement.files for measured in measurements)
    return results.Provenance(
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        model_sha256=robot.sha256,
        data_sha256={str(file): results.sha256(file.read_bytes()) for file in files},
        versions={
            "python": platform.python_version(),
            "mukca": __version__,
            "casadi": ca.__version__,
            "numpy": np.__version__,
        },
    )

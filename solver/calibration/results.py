"""Document of a calibration: a fit and its figures, as ``calibration.json`` holds them."""

import hashlib
import platform
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from typing import Any

import casadi as ca
import numpy as np

from ..._version import __version__
from ..data import Measurement, evaluate, is_distorted
from ..paper import REGULARIZATION
from ..results import (
    FORMAT,
    CalibrationDocument,
    CarriedLoad,
    FramePose,
    Model,
    PlacementErrors,
    PlacementSamples,
    Provenance,
    RecordedSample,
    Role,
)
from ..robot import Robot
from . import estimates
from .errors import ball_refitted, frames_of, history, models_of, placement_errors, summarise
from .fit import Fit
from .frames import frame_poses
from .problem import CalibrationProblem

UNKNOWN = (
    "how well the calibration is known could not be computed: the samples are too few or too much "
    "alike; record more that differ"
)


def document_of(problem: CalibrationProblem, fit: Fit) -> CalibrationDocument:
    """Return all that is to be kept of a calibration; nothing is written yet."""
    calibrated, options = fit.calibrated, problem.options
    warnings = problem.warnings
    if not _is_known(fit):
        warnings = (*warnings, UNKNOWN)
        fit = replace(fit, posterior=None)
    placements = _errors(problem, fit)
    return CalibrationDocument(
        format=FORMAT,
        robot=problem.robot.source,
        method=options.method,
        optimizer=fit.optimizer,
        iterations=fit.iterations,
        converged=True,
        solve_seconds=fit.seconds,
        placements=placements,
        summary=summarise(placements),
        distorted=_distorted(fit, problem.train),
        parameters=estimates.parameter_values(calibrated, fit.posterior),
        choices=fit.choices,
        history=history(fit.iterates, problem.train, problem.test),
        settings={**problem.robot.loaded_with, **options.as_dict()},
        provenance=_provenance(problem.robot, (*problem.train, *problem.test)),
        checks=problem.findings(fitted=fit.posterior is not None),
        next_placement=None if problem.inspected is None else problem.inspected.next_placement,
        warnings=warnings,
        outputs={},
        model=_model(problem.robot, calibrated.urdf().decode()),
        deflection={
            extension: tuple(values.tolist())
            for extension, values in zip(
                calibrated.deflection.extensions, calibrated.deflection.coefficients, strict=True
            )
        },
        load=CarriedLoad(gravity=calibrated.load.gravity, payload=calibrated.load.payload),
        data=_samples(problem, fit),
        scale=estimates.scale_of(fit),
        outlook=estimates.outlook_of(problem, fit),
        **_known(problem, fit),
    )


def _is_known(fit: Fit) -> bool:
    """Tell whether a posterior, where there is one, has a covariance."""
    if fit.posterior is None:
        return True
    covariance = fit.posterior.covariance
    return bool(np.isfinite(covariance).all() and (np.diag(covariance) >= 0).all())


def _errors(problem: CalibrationProblem, fit: Fit) -> tuple[PlacementErrors, ...]:
    robot, weight = problem.robot, problem.options.regularization or REGULARIZATION
    models = {
        **models_of(fit.calibrated),
        **ball_refitted(robot, problem.train, weight),
    }
    frames = frames_of(models, problem.train)
    roles: tuple[tuple[Role, Sequence[Measurement]], ...] = (
        ("train", problem.train),
        ("test", problem.test),
    )
    return tuple(
        placement_errors(models, role, measured, fit.posterior, fit.calibrated, frames)
        for role, placements in roles
        for measured in placements
    )


def _known(problem: CalibrationProblem, fit: Fit) -> dict[str, Any]:
    """Return how well everything is known; nothing where the method does not say."""
    if fit.posterior is None:
        return {}
    return {
        "coefficients": estimates.coefficient_values(fit.posterior),
        "groups": estimates.prior_widths(fit.posterior),
        "noise": estimates.noise_scale(fit.posterior),
        "log_evidence": fit.posterior.log_evidence,
        "frames": _frames(fit),
        "uncertainty": estimates.uncertainty_of(
            fit.posterior, fit.calibrated, (*problem.train, *problem.test)
        ),
    }


def _frames(fit: Fit) -> tuple[FramePose, ...] | None:
    """Return the poses of the frames, which are results of the first robot, in its base."""
    joint = fit.joint_posterior
    if joint is None or fit.posterior is not joint.arms[0]:
        return None
    return frame_poses(joint) or None


def _distorted(fit: Fit, train: Sequence[Measurement]) -> tuple[str, ...]:
    """Return the placements whose distance between sockets the model does not reproduce."""
    errors = [(m, evaluate(fit.calibrated.ball(m.positions, m.efforts), m)) for m in train]
    return tuple(m.name for m, metrics in errors if is_distorted(metrics, m))


def _samples(problem: CalibrationProblem, fit: Fit) -> tuple[PlacementSamples, ...]:
    weights = _weights(problem.train, fit)
    return (
        *(_recorded(m, "train", weights.get(m.name)) for m in problem.train),
        *(_recorded(m, "test") for m in problem.test),
    )


def _weights(train: Sequence[Measurement], fit: Fit) -> dict[str, list[float]]:
    """Return each training placement's robust weights, in the order of its samples."""
    weights: dict[str, list[float]] = {}
    rest: list[float] = [] if fit.posterior is None else fit.posterior.weights.tolist()
    for measured in train if rest else ():
        queues: dict[int, Iterator[float]] = {}
        for socket, count in zip(measured.sockets, measured.counts, strict=True):
            queues[socket], rest = iter(rest[:count]), rest[count:]
        weights[measured.name] = [next(queues[s.socket]) for s in measured.placement.samples]
    return weights


def _recorded(
    measured: Measurement, role: Role, weights: Sequence[float] | None = None
) -> PlacementSamples:
    """Return a placement's samples, columns in chain order, with their robust weights."""
    return PlacementSamples(
        name=measured.name,
        role=role,
        distance=measured.distance,
        frame=measured.placement.frame,
        files=tuple(map(str, measured.placement.files)),
        samples=tuple(
            RecordedSample(
                socket=sample.socket,
                position=sample.position,
                effort=sample.effort,
                point=sample.point,
                where=sample.where,
                weight=None if weights is None else weights[i],
            )
            for i, sample in enumerate(measured.placement.samples)
        ),
    )


def _model(robot: Robot, calibrated_urdf: str) -> Model:
    return Model(
        name=robot.name,
        source=robot.source,
        sha256=robot.sha256,
        base=robot.base,
        tip=robot.tip,
        joint_names=robot.joint_names,
        nominal_urdf=robot.text.data.decode(),
        calibrated_urdf=calibrated_urdf,
    )


def _provenance(robot: Robot, measurements: Sequence[Measurement]) -> Provenance:
    """Return what a result was made from and with: digests, versions, time."""
    return Provenance(
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        model_sha256=robot.sha256,
        data_sha256={
            str(file): hashlib.sha256(file.read_bytes()).hexdigest()
            for measured in measurements
            for file in measured.placement.files
        },
        versions={
            "python": platform.python_version(),
            "mukca": __version__,
            "casadi": ca.__version__,
            "numpy": np.__version__,
        },
    )

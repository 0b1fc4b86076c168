"""A fit and its figures, composed as ``calibration.json`` holds them."""

import hashlib
import platform
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timezone
from typing import Any

import casadi as ca
import numpy as np

from ..._version import __version__
from ..bayes.inference import Posterior
from ..data import Measurement, evaluate, is_distorted
from ..paper import REGULARIZATION
from ..results import FORMAT, CalibrationDocument, FramePose, Model, Provenance
from ..results.calibration import CarriedLoad, PlacementErrors, Role
from ..robot import Robot
from . import estimates
from .errors import history, placement_errors, summarise
from .fit import Fit
from .frames import frame_poses
from .models import ball_refitted, frames_of, models_of
from .outlook import outlook_of
from .problem import CalibrationProblem
from .recorded import recorded, weights_by_placement

UNKNOWN = (
    "how well the calibration is known could not be computed: the samples are too few or too much "
    "alike; record more that differ"
)


def compose(task: CalibrationProblem, fit: Fit) -> CalibrationDocument:
    """Return all that is to be kept of a calibration; nothing is written yet."""
    calibrated, settings = fit.calibrated, task.settings
    warnings = task.warnings
    if fit.posterior is not None and not _is_finite(fit.posterior):
        warnings = (*warnings, UNKNOWN)
        fit = replace(fit, posterior=None)
    placements = _errors(task, fit)
    return CalibrationDocument(
        format=FORMAT,
        robot=task.robot.source,
        method=settings.method,
        optimizer=fit.optimizer,
        iterations=fit.iterations,
        converged=True,
        solve_seconds=fit.seconds,
        placements=placements,
        summary=summarise(placements),
        distorted=_distorted(fit, task.train),
        parameters=estimates.parameter_values(calibrated, fit.posterior),
        choices=fit.choices,
        history=history(fit.iterates, task.train, task.test),
        settings={**task.robot.loaded_with, **settings.as_dict()},
        provenance=_provenance(task.robot, (*task.train, *task.test)),
        checks=None if task.inspected is None else task.inspected.findings,
        next_placement=None if task.inspected is None else task.inspected.next_placement,
        warnings=warnings,
        outputs={},
        model=_model(task.robot, calibrated.urdf().decode()),
        deflection={
            extension: tuple(values.tolist())
            for extension, values in zip(
                calibrated.deflection.extensions, calibrated.deflection.coefficients, strict=True
            )
        },
        load=CarriedLoad(gravity=calibrated.load.gravity, payload=calibrated.load.payload),
        data=_samples(task, fit),
        scale=estimates.scale_of(fit),
        outlook=outlook_of(task, fit),
        **_known(fit),
    )


def _is_finite(posterior: Posterior) -> bool:
    """Tell whether a posterior says how well everything is known."""
    covariance = posterior.covariance
    return bool(np.isfinite(covariance).all() and (np.diag(covariance) >= 0).all())


def _errors(task: CalibrationProblem, fit: Fit) -> tuple[PlacementErrors, ...]:
    robot, weight = task.robot, task.settings.regularization or REGULARIZATION
    models = {
        **models_of(fit.calibrated),
        **ball_refitted(robot, task.train, weight),
    }
    frames = frames_of(models, task.train)
    roles: tuple[tuple[Role, Sequence[Measurement]], ...] = (
        ("train", task.train),
        ("test", task.test),
    )
    return tuple(
        placement_errors(models, role, measured, fit.posterior, fit.calibrated, frames)
        for role, placements in roles
        for measured in placements
    )


def _known(fit: Fit) -> dict[str, Any]:
    """Return how well everything is known; nothing where the method does not say."""
    if fit.posterior is None:
        return {}
    return {
        "coefficients": estimates.coefficient_values(fit.posterior),
        "groups": estimates.prior_widths(fit.posterior),
        "noise": estimates.noise_scale(fit.posterior),
        "log_evidence": fit.posterior.log_evidence,
        "frames": _frames(fit),
        "uncertainty": estimates.uncertainty_of(fit.posterior, fit.calibrated.load),
    }


def _frames(fit: Fit) -> tuple[FramePose, ...] | None:
    """Return where the frames stand; of several robots, the first tells it, in its own base."""
    world = fit.world
    return (
        None if world is None or fit.posterior is not world.arms[0] else frame_poses(world) or None
    )


def _distorted(fit: Fit, train: Sequence[Measurement]) -> tuple[str, ...]:
    """Return the placements whose distance between sockets the model does not reproduce."""
    errors = [(m, evaluate(fit.calibrated.ball(m.positions, m.efforts), m)) for m in train]
    return tuple(m.name for m, metrics in errors if is_distorted(metrics, m))


def _samples(task: CalibrationProblem, fit: Fit) -> tuple[Any, ...]:
    weights: dict[str, list[float]] = {}
    if fit.posterior is not None:
        weights = weights_by_placement(task.train, fit.posterior)
    return (
        *(recorded(m, "train", weights.get(m.name)) for m in task.train),
        *(recorded(m, "test") for m in task.test),
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

"""Document of a calibration: a fit and its figures, as ``calibration.json`` holds them."""

import hashlib
import platform
from collections.abc import Sequence
from datetime import datetime, timezone
from itertools import chain

import casadi as ca
import numpy as np

from ..._version import __version__
from .. import results
from ..bayes.inference import Posterior
from ..data import Measurement, as_point, evaluate, is_distorted
from ..robot import Robot
from . import estimates
from .errors import ball_refitted, errors_of, history
from .fit import Fit
from .outlook import outlook_of
from .problem import CalibrationProblem

UNKNOWN = (
    "how well the calibration is known could not be computed: the samples are too few or too much "
    "alike; record more that differ"
)


def document_of(problem: CalibrationProblem, fit: Fit) -> results.CalibrationDocument:
    """Return all that is to be kept of a calibration; nothing is written yet."""
    calibrated = fit.calibrated
    options = problem.options
    warnings = problem.warnings
    posterior = fit.posterior
    selected = fit.selected
    if selected is not None:
        warnings = (*warnings, UNKNOWN) if posterior is None else warnings
        problem = problem.at_rest(
            posterior and posterior.moved, selected.movements, calibrated
        )
    before = ball_refitted(problem)
    deflection = calibrated.deflection
    errors = errors_of(problem, fit, before)
    with_errors = (
        (m, evaluate(calibrated.predict(m), m)) for m in problem.measurements
    )
    coefficients = zip(deflection.extensions, deflection.coefficients, strict=True)
    parameters = estimates.known_of(fit, problem, before)
    names = problem.robot.joint_names
    for m in problem.test:
        beyond = results.beyond_words(
            parameters.get("curves"), names, m.positions, m.name
        )
        warnings = (*warnings, *beyond)
    return results.CalibrationDocument(
        format=results.FORMAT,
        robot=problem.robot.source,
        method=options.method,
        optimizer=fit.optimizer,
        iterations=len(fit.iterates) - 1,
        converged=True,
        solve_seconds=fit.seconds,
        placements=errors.placements,
        summary=errors.summary,
        distorted=tuple(
            m.name for m, metrics in with_errors if is_distorted(metrics, m)
        ),
        parameters=estimates.parameter_values(calibrated, posterior),
        rotation_numbers=calibrated.rotation_numbers,
        choices=selected and selected.notes,
        history=history(fit.iterates, problem.measurements, problem.test),
        settings={**problem.robot.loaded_with, **options.as_dict()},
        provenance=_provenance(problem.robot, [m for _, m in problem.placements]),
        checks=problem.checks,
        hypotheses=problem.survey.hypotheses,
        next_placement=problem.next_placement,
        warnings=warnings,
        outputs={},
        model=results.Model.filled(
            problem.robot,
            nominal_urdf=problem.robot.text.data.decode(),
            calibrated_urdf=calibrated.urdf().decode(),
        ),
        deflection={name: tuple(values.tolist()) for name, values in coefficients},
        load=calibrated.load,
        refitted_ball=None if before is None else as_point(before.values),
        data=_samples(problem, posterior),
        scale=estimates.scale_of(fit),
        outlook=outlook_of(problem, fit),
        **parameters,
    )


def _samples(
    problem: CalibrationProblem, posterior: Posterior | None
) -> tuple[results.PlacementSamples, ...]:
    """Return all samples; those trained on have robust weights, which come socket by socket."""
    of_balls = np.zeros(0)
    of_turns = np.zeros(0)
    if posterior is not None:
        turned = posterior.data.turned
        of_balls = posterior.weights[~turned]
        of_turns = posterior.weights[turned]
    rows: list[results.PlacementSamples] = []
    for role, measured in problem.placements:
        placement = measured.placement
        count = len(placement.samples)
        of_ball = of_turn = shifts = [None] * count
        if of_balls.size:
            of_ball = measured.as_recorded(of_balls[:count]).tolist()
            of_balls = of_balls[count:]
            if measured.has_orientations:
                of_turn = of_turns[:count].tolist()
                of_turns = of_turns[count:]
        if measured.moved is not None:
            shifts = list(map(as_point, measured.as_recorded(measured.moved)))
        samples = [
            results.RecordedSample.filled(
                sample, weight=weight, orientation_weight=turn, moved=shift
            )
            for sample, weight, turn, shift in zip(
                placement.samples, of_ball, of_turn, shifts, strict=True
            )
        ]
        rows.append(
            results.PlacementSamples.filled(
                placement,
                role=role,
                distance=measured.distance,
                files=tuple(map(str, placement.files)),
                samples=tuple(samples),
            )
        )
    return tuple(rows)


def _provenance(
    robot: Robot, measurements: Sequence[Measurement]
) -> results.Provenance:
    """Return what a result was made from and with: digests, versions, time."""
    files = chain.from_iterable(measured.placement.files for measured in measurements)
    return results.Provenance(
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        model_sha256=robot.sha256,
        data_sha256={
            str(file): hashlib.sha256(file.read_bytes()).hexdigest() for file in files
        },
        versions={
            "python": platform.python_version(),
            "mukca": __version__,
            "casadi": ca.__version__,
            "numpy": np.__version__,
        },
    )

"""An earlier calibration of the same arm as prior of a new one (``--prior``).

Its posterior is what is known before the new samples come: geometry, elasticity, error curves, and
how they go together. Its file holds it; older files hold the samples, which are fitted again.
"""

import base64
import zlib
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..bayes.inference import JointPosterior, Posterior, restored_covariance
from ..bayes.model import KINDS, GivenPrior, Noise, extend
from ..data import Load, Pose, RobotRecordings, as_point, measure, observe_all, spaced
from ..results import (
    CalibrationDocument,
    StoredPosterior,
    calibrated_robot,
    misfit,
    read_calibration,
)
from ..robot import Origin, Robot
from .options import SolveOptions, UsageError, option_table
from .type_prior import TypePriors, type_priors

TOOL, BASE = "tool", "base"
Priors = TypePriors | GivenPrior


def priors_of(options: SolveOptions, robots: Sequence[RobotRecordings]) -> Priors:
    """Return what is known of some robots before their samples, as the options say."""
    if options.prior is None:
        return type_priors(options.type_prior, [one.robot for one in robots])
    if len(robots) > 1:
        raise UsageError("--prior: of one robot; several were given")
    return earlier_prior(Path(options.prior), robots[0].robot, options.remounted)


def earlier_prior(file: Path, robot: Robot, remounted: Collection[str]) -> GivenPrior:
    """Return what an earlier calibration leaves known of an arm's unknowns.

    Args:
        file: Its ``calibration.json``.
        robot: The nominal robot of the new calibration.
        remounted: What was taken off since, ``tool`` or ``base``: nothing is known of where it is.

    Raises:
        UsageError: It is of another arm, or by a method that leaves no posterior.
        DocumentError: The file is missing, of another format, or damaged.
    """
    document = read_calibration(file)
    if document.model.joint_names != robot.joint_names:
        theirs, ours = (
            ", ".join(names) for names in (document.model.joint_names, robot.joint_names)
        )
        raise UsageError(f"--prior {file}: of an arm with the joints {theirs}; this has {ours}")
    found = posterior_of(document, str(file))
    model, names = found.model, found.model.names
    origins = robot.origins.ravel()
    nominal = np.array([origins[p.index] for p in model.parameters])
    mean = found.x.copy()
    mean[: model.geometry] = found.values - nominal
    curves = document.curves
    size = model.size
    prior = GivenPrior(
        tuple(names),
        mean,
        found.covariance[:size, :size],
        (0.0, 0.0) if curves is None else (curves.amplitude, curves.length),
    )
    first = model.parameters[0].joint if model.parameters else ""
    moved = {
        p.name
        for p in model.parameters
        if (p.of_ball and TOOL in remounted) or (p.joint == first and BASE in remounted)
    }
    return prior.without(moved)


def stored_posterior(found: JointPosterior) -> StoredPosterior | None:
    """Return what a calibration's file keeps of a posterior; None of several robots."""
    arm, *others = found.arms
    if others:
        return None
    kept = np.r_[: arm.model.scalars, arm.model.size : len(found.covariance)]
    triangle = found.covariance[np.ix_(kept, kept)][np.tril_indices(len(kept))].astype("<f8")
    text = base64.b64encode(zlib.compress(triangle.tobytes())).decode()
    noises = {kind: (one.space, one.joint, one.nu) for kind, one in arm.noises.items()}
    centres = tuple(map(as_point, arm.centres))
    return StoredPosterior(covariance=text, noises=noises, centres=centres)


def posterior_of(document: CalibrationDocument, source: str) -> Posterior:
    """Return the posterior of a calibration: as its file holds it, or else fitted again.

    What an older file lacks, as one does whose zeros were found since, its samples give.

    Args:
        document: The calibration.
        source: Its file, for messages.

    Raises:
        UsageError: It is of several arms, or by a method that leaves no posterior.
        DocumentError: The file is damaged.
    """
    from .fit import fit_robots

    arm, options = _recordings(document, source)
    kept, settings = document.posterior, document.settings
    chained = document.curves is not None and settings.get("prior")
    if kept is not None and not (document.later_zeros or settings.get("zeros") or chained):
        return _stored(document, kept, arm, options, source)
    (fit,) = fit_robots([arm], options)
    assert fit.posterior is not None
    return fit.posterior


def _stored(
    document: CalibrationDocument,
    kept: StoredPosterior,
    arm: RobotRecordings,
    options: SolveOptions,
    source: str,
) -> Posterior:
    """Return the posterior that a file holds."""
    calibrated = calibrated_robot(document, source)
    model = extend(calibrated.robot, calibrated.parameters, calibrated.deflection.extensions)
    changes = calibrated.values - model.ball.nominal
    x = np.concatenate([changes, *calibrated.deflection.coefficients])
    scene = observe_all(
        [arm], known=options.distances, sockets_at=options.located, require_scale=False
    )
    data, count = scene.arms[0], model.scalars + 6 * len(scene.arms[0].frames)
    count += 3 * data.socket_count
    try:
        triangle = np.frombuffer(zlib.decompress(base64.b64decode(kept.covariance)), "<f8")
        covariance = np.zeros((count, count))
        covariance[np.tril_indices(count)] = triangle
    except (ValueError, zlib.error):
        raise misfit(source, "posterior.covariance", "damaged; calibrate again") from None
    covariance += np.tril(covariance, -1).T
    trained = [part for part in document.data if part.role == "train"]
    rows = [s for part in trained for s in sorted(part.samples, key=lambda one: one.socket)]
    told = [*(s.weight for s in rows), *(s.orientation_weight for s in rows if s.orientation)]
    frames = {frame.name: Pose.of(Origin(frame.xyz, frame.rpy)) for frame in document.frames or ()}
    found = Posterior(
        model,
        data,
        x,
        np.reshape(kept.centres, (-1, 3)),
        covariance,
        (),
        {kind: Noise(*kept.noises[kind]) for kind in KINDS if kind in kept.noises},
        model.predict(x, data.positions, data.torques),
        np.array(told, dtype=float),
        document.log_evidence or 0.0,
        (x,),
    )
    poses, curves = tuple(frames[name] for name in data.frames), document.curves
    scales = (0.0, 0.0) if curves is None else (curves.amplitude, curves.length)
    return replace(found, covariance=restored_covariance(found, scene, poses, scales))


def _recordings(document: CalibrationDocument, source: str) -> tuple[RobotRecordings, SolveOptions]:
    """Return what a calibration was fitted to.

    Raises:
        UsageError: It is of several arms, or by a method that leaves no posterior.
    """
    if document.method != "auto" or document.arms is not None:
        raise UsageError(f"{source}: give a calibration of one arm by --method auto")

    robot = calibrated_robot(document, source).robot
    later = {zero.joint: zero.offset for zero in document.later_zeros}
    zeros = [later.get(joint, 0.0) for joint in robot.joint_names]
    known = {name: value for name, value in document.settings.items() if name in option_table()}
    options = replace(SolveOptions(**known), accept_distorted=True).validated()
    placements = [
        replace(data.shifted(zeros).placement(robot.joint_names), files=())
        for data in document.data
        if data.role == "train"
    ]
    train = [
        spaced(measure(p, robot, options.distance, sockets=1), p.name, options.located)
        for p in placements
    ]
    load = Load(document.load.gravity, document.load.payload)
    return RobotRecordings(robot, train, load), options

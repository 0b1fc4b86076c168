"""An earlier calibration of the same arm as prior of a new one (``--prior``).

Its file holds the posterior, geometry, elasticity and error curves; older ones are fitted again.
"""

import base64
import zlib
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .. import results
from ..bayes.inference import JointPosterior, Posterior, restored_covariance
from ..bayes.model import KINDS, GivenPrior, Noise, extend
from ..data import (
    IDENTITY,
    WORLD,
    Measurement,
    Pose,
    RobotRecordings,
    as_point,
    base_name,
    measure,
    observe_all,
    spaced,
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
    """Return what an earlier calibration leaves known of an arm's unknowns."""
    document = results.read_calibration(file)
    joints = document.model.joint_names, robot.joint_names
    if joints[0] != joints[1]:
        theirs, ours = map(", ".join, joints)
        raise UsageError(f"--prior {file}: of an arm with the joints {theirs}; this has {ours}")
    found = posterior_of(document, str(file))
    model = found.model
    origins = robot.origins.ravel()
    nominal = np.array([origins[p.index] for p in model.parameters])
    mean = found.x.copy()
    mean[: model.geometry] = found.values - nominal
    covariance = found.covariance[: model.size, : model.size]
    prior = GivenPrior(tuple(model.names), mean, covariance, _scales(document))
    first = model.parameters[0].joint if model.parameters else ""
    moved = {
        p.name
        for p in model.parameters
        if (p.of_ball and TOOL in remounted) or (p.joint == first and BASE in remounted)
    }
    return prior.without(moved)


def stored_posterior(
    found: JointPosterior | None, robot: int, recordings: RobotRecordings
) -> results.StoredPosterior | None:
    """Return what a robot's file keeps of a posterior: of its unknowns, frames, and sockets.

    None of none, and of a robot among several whose balls an instrument measured.
    """
    if found is None or (found.arms[1:] and (found.arms[robot].data.sockets < 0).any()):
        return None
    arm, own = found.arms[robot], found.own[robot]
    scalars, end = arm.model.scalars, len(found.covariance)
    turned = np.zeros((scalars + end - found.own[-1].stop, end))
    rows = np.arange(scalars)
    turned[rows, own.start + rows] = 1.0
    turned[scalars:, found.own[-1].stop :] = np.eye(len(turned) - scalars)
    centres = arm.centres
    if found.arms[1:]:
        turned, centres = _in_own_base(found, robot, recordings, turned[:scalars])
    told = np.flatnonzero(turned.any(axis=0))  # none of the curves
    turned = turned[:, told]
    sigma = turned @ found.covariance[np.ix_(told, told)] @ turned.T
    triangle = sigma[np.tril_indices(len(sigma))].astype("<f8")
    text = base64.b64encode(zlib.compress(triangle.tobytes())).decode()
    noises = {kind: (one.space, one.joint, one.nu) for kind, one in arm.noises.items()}
    places = tuple(map(as_point, centres))
    return results.StoredPosterior(covariance=text, noises=noises, centres=places)


def _in_own_base(
    found: JointPosterior, robot: int, recordings: RobotRecordings, unknowns: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of unknowns and own sockets by all there is, and these sockets."""
    arm, base, count = found.arms[robot], found.scene.bases[robot], len(found.arms)
    pose = IDENTITY if base == WORLD else list(found.frames.values())[base]
    named = [(base_name(m, count), s) for m in recordings.measurements for s in m.sockets]
    kept = [arm.data.labels.index(name) for name in named]
    frames, end = found.own[-1].stop, unknowns.shape[1]
    first, parts = end - arm.centres.size, [unknowns]
    for k in kept:
        own = np.zeros((3, end))
        own[:, first + 3 * k : first + 3 * k + 3] = pose.rotation.T
        if base != WORLD:
            slopes = pose.slopes(arm.centres[k : k + 1])[0]
            own[:, frames + 6 * base : frames + 6 * base + 6] = -pose.rotation.T @ slopes
        parts.append(own)
    return np.concatenate(parts), arm.centres[kept]


def posterior_of(document: results.CalibrationDocument, source: str) -> Posterior:
    """Return the posterior of a calibration: as its file holds it, or else fitted again.

    What an older file lacks, as one does whose zeros were found since, its samples give.
    """
    from .fit import fit_robots

    arm, options = _recordings(document, source)
    kept, settings = document.posterior, document.settings
    chained = document.curves is not None and settings.get("prior")
    if kept is not None and not (document.later_zeros or settings.get("zeros") or chained):
        return _stored(document, kept, arm, options, source)
    if document.arms is not None:
        raise UsageError(f"{source}: of several arms, or by an older mukca; calibrate it alone")
    (fit,) = fit_robots([arm], options)
    assert fit.posterior is not None
    return fit.posterior


def _stored(
    document: results.CalibrationDocument,
    kept: results.StoredPosterior,
    arm: RobotRecordings,
    options: SolveOptions,
    source: str,
) -> Posterior:
    """Return the posterior that a file holds."""
    calibrated = results.calibrated_robot(document, source)
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
        raise results.misfit(source, "posterior.covariance", "damaged; calibrate again") from None
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
    poses = tuple(frames[name] for name in data.frames)
    return replace(found, covariance=restored_covariance(found, scene, poses, _scales(document)))


def _scales(document: results.CalibrationDocument) -> tuple[float, float]:
    """Return amplitude and length of the error curves; zeros for none."""
    curves = document.curves
    return (0.0, 0.0) if curves is None else (curves.amplitude, curves.length)


def _recordings(
    document: results.CalibrationDocument, source: str
) -> tuple[RobotRecordings, SolveOptions]:
    """Return what a calibration was fitted to."""
    if document.method != "auto":
        raise UsageError(f"{source}: give a calibration by --method auto")

    robot = results.calibrated_robot(document, source).robot
    later = {zero.joint: zero.offset for zero in document.later_zeros}
    zeros = [later.get(joint, 0.0) for joint in robot.joint_names]
    known = {name: value for name, value in document.settings.items() if name in option_table()}
    options = replace(SolveOptions(**known), accept_distorted=True)
    if document.arms is not None:  # what ties it to the others is in its posterior
        options = replace(options, known=(), sockets_at=())
    options = options.validated()
    train: list[Measurement] = []
    for data in (data for data in document.data if data.role == "train"):
        placement = replace(data.shifted(zeros).placement(robot.joint_names), files=())
        measured = measure(placement, robot, options.distance, sockets=1)
        train.append(spaced(measured, data.name, options.located))
    return RobotRecordings(robot, train, document.load), options

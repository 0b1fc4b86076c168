"""The posterior of an earlier calibration: stored in its file, and the prior of the next."""

import base64
import zlib
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from .. import results
from ..curves import restored_covariance
from ..identification.data import (
    SOURCE_KINDS,
    Measurement,
    Observations,
    Pose,
    RobotRecordings,
    measure,
    observe,
    spaced,
)
from ..identification.effects import TILT
from ..identification.inference import Posterior, with_average_width
from ..identification.model import (
    ExtendedModel,
    GivenPrior,
    Noise,
    PriorGroup,
    extend,
    groups_at,
    rare_in,
)
from ..identification.robot import BallModel, Origin
from .fit import fit_robot
from .options import OPTION_TABLE, SolveOptions, UsageError
from .tables import METHODS


def prior_of(
    options: SolveOptions, robots: Sequence[RobotRecordings]
) -> GivenPrior | None:
    """Return what an earlier calibration left known, where the options name one.

    Raises:
        UsageError: They name one for several robots, or of another arm.
    """
    if options.prior is None:
        return None
    if len(robots) > 1:
        raise UsageError("--prior: of one robot; several were given")
    file, robot, remounted = Path(options.prior), robots[0].robot, options.remounted
    document = results.read_calibration(file)
    theirs, ours = map(", ".join, (document.model.joint_names, robot.joint_names))
    if theirs != ours:
        raise UsageError(
            f"--prior {file}: of an arm with the joints {theirs}; this has {ours}"
        )
    posterior = posterior_of(document, str(file))
    model, values = posterior.model, posterior.values
    ball = BallModel(robot, model.ball.free.tolist())
    mean = posterior.x.copy()
    slopes = np.eye(model.size)
    n = model.geometry
    mean[:n] = ball.parameters_at(model.ball.origins(values)) - ball.nominal
    slopes[:n, :n] = ball.slopes_of(model.ball, values)
    covariance = slopes @ posterior.of_unknowns @ slopes.T
    prior = GivenPrior(tuple(model.names), mean, covariance, _scales(document))
    first_joint = model.parameters[0].joint
    shifts = {
        parameter.name
        for parameter in model.parameters
        if (parameter.of_ball and "tool" in remounted)
        or (parameter.joint == first_joint and "base" in remounted)
    }
    by_frame = all(joint.tilts_by_frame for joint in robot.actuated)
    if document.rotation_numbers == "rpy" and not by_frame:
        # files of 1.0 hold tilts about other axes than today's
        shifts |= {*TILT.coefficient_names(robot.joint_names)}
    return prior.without(shifts)


def _unpacked(text: str, count: int) -> np.ndarray:
    """Return a symmetric matrix of text, shape (count, count); ValueError, zlib.error for none."""
    size = count * (count + 1) // 2
    content = zlib.decompressobj().decompress(base64.b64decode(text), 8 * size + 1)
    matrix = np.zeros((count, count))
    matrix[np.tril_indices(count)] = np.frombuffer(content, "<f8").reshape(size)
    return matrix + np.tril(matrix, -1).T


def posterior_of(document: results.CalibrationDocument, source: str) -> Posterior:
    """Return the posterior of a calibration: as stored in its file, or else fitted again.

    It is fitted again for older files, and where joint zeros were found since.
    """
    arm, options = _fitted_to(document, source)
    stored = document.posterior
    chained = document.curves is not None and options.prior
    changed = document.later_zeros or options.zeros or chained
    if stored is not None and not changed:
        return _stored(document, stored, arm, options, source)
    if document.arms is not None:
        raise UsageError(
            f"{source}: of several arms, or by an older mukca; calibrate it alone"
        )
    fit = fit_robot(arm, options, METHODS, prior=prior_of(options, [arm]))
    assert fit.posterior is not None
    return fit.posterior


def _stored(
    document: results.CalibrationDocument,
    stored: results.StoredPosterior,
    arm: RobotRecordings,
    options: SolveOptions,
    source: str,
) -> Posterior:
    """Return the posterior that a file holds."""
    calibrated = results.calibrated_robot(document, source)
    model = extend(
        calibrated.robot,
        calibrated.parameters,
        calibrated.deflection.extensions,
        calibrated.rotation_numbers,
    )
    changes = calibrated.values - model.ball.nominal
    x = np.concatenate([changes, *calibrated.deflection.coefficients])
    data = observe(
        arm, lengths=options.distances, sockets_at=options.located, require_scale=False
    )
    count = model.scalars + 6 * len(data.frames) + 3 * data.socket_count
    try:
        covariance = _unpacked(stored.covariance, count)
    except (ValueError, zlib.error):
        raise results.misfit(
            source, "posterior.covariance", "damaged; calibrate again"
        ) from None
    training = [part for part in document.data if part.role == "train"]
    rows = [*chain.from_iterable(part.by_socket for part in training)]
    weights = [sample.weight for sample in rows]
    weights += [sample.orientation_weight for sample in rows if sample.orientation]
    posterior = Posterior(
        model,
        data,
        x,
        np.reshape(stored.centres, (-1, 3)),
        covariance,
        _stored_groups(document, model, data),
        {
            kind: Noise(*stored.noises[kind])
            for kind in SOURCE_KINDS
            if kind in stored.noises
        },
        model.predict(x, data),
        np.array(weights, dtype=float),
        document.log_evidence or 0.0,
        (x,),
    )
    origins = {
        frame.name: Origin(frame.xyz, frame.rpy) for frame in document.frames or ()
    }
    poses = tuple(Pose.of(origins[name]) for name in data.frames)
    restored = restored_covariance(posterior, data, poses, _scales(document))
    return replace(posterior, covariance=restored)


def _stored_groups(
    document: results.CalibrationDocument, model: ExtendedModel, data: Observations
) -> tuple[PriorGroup, ...]:
    """Return the priors beside which a stored covariance stands."""
    stored = {group.name: group for group in document.groups or ()}
    widths = {name: group.width for name, group in stored.items()}
    return tuple(
        with_average_width(replace(group, effective=stored[group.name].effective))
        for group in groups_at(model, data, widths)
    )


def _scales(document: results.CalibrationDocument) -> tuple[float, float]:
    """Return amplitude and length of the error curves; zeros for none."""
    curves = document.curves
    return (0.0, 0.0) if curves is None else (curves.amplitude, curves.length)


def _fitted_to(
    document: results.CalibrationDocument, source: str
) -> tuple[RobotRecordings, SolveOptions]:
    """Return what a calibration was fitted to."""
    if document.method != "auto":
        raise UsageError(f"{source}: give a calibration by --method auto")
    robot = results.calibrated_robot(document, source).robot
    known_names = document.settings.keys() & OPTION_TABLE.keys()
    stored: dict[str, Any] = {name: document.settings[name] for name in known_names}
    stored["accept_distorted"] = True
    if document.arms is not None:  # what ties it to the others is in its posterior
        stored |= {"known": (), "sockets_at": ()}
    options = SolveOptions(**stored).validated()
    train: list[Measurement] = []
    for part in document.data:
        if part.role == "train":
            original = part.shifted(document.later_offsets)
            recorded = original.placement(robot.joint_names)
            measured = measure(
                replace(recorded, files=()), robot, options.distance, sockets=1
            )
            train.append(spaced(measured, part.name, options.located))
    effects = rare_in(document.deflection, robot.joint_names)
    return RobotRecordings(robot, train, document.load, effects), options

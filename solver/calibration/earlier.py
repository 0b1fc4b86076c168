"""An earlier calibration of the same arm as prior of a new one (``--prior``).

Its file holds all samples that it was fitted to, so it is fitted again, and its posterior is what
is known before the new samples come: geometry, elasticity, error curves, and how they go together.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..bayes.model import GivenPrior
from ..data import Load, RobotRecordings, measure, spaced
from ..results import CalibrationDocument, calibrated_robot, read_calibration
from ..robot import Robot
from .options import SolveOptions, UsageError, option_table
from .type_prior import TypePriors, type_priors

if TYPE_CHECKING:
    from ..bayes.inference import Posterior

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
    curves = found.groups[-1]
    size = model.size
    prior = GivenPrior(
        tuple(names),
        mean,
        found.covariance[:size, :size],
        (0.0, 0.0) if curves.length is None else (curves.width, curves.length),
    )
    first = model.parameters[0].joint if model.parameters else ""
    moved = {
        p.name
        for p in model.parameters
        if (p.of_ball and TOOL in remounted) or (p.joint == first and BASE in remounted)
    }
    return prior.without(moved)


def posterior_of(document: CalibrationDocument, source: str) -> "Posterior":
    """Return the posterior of a calibration, fitted again to the samples in its file.

    Args:
        document: The calibration.
        source: Its file, for messages.

    Raises:
        UsageError: It is of several arms, or by a method that leaves no posterior.
    """
    from .fit import fit_robots

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
    (fit,) = fit_robots([RobotRecordings(robot, train, load)], options)
    assert fit.posterior is not None
    return fit.posterior

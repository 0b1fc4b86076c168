"""Fit of one robot or several, by the paper's method or by the default one."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..bases import TiedRobots, Visitor, places_alone, tie
from ..curves import with_joint_curves
from ..identification.data import WORLD, RobotRecordings, observations_at, places_of
from ..identification.inference import Posterior
from ..identification.paper import build_problem, covariance, solve
from ..identification.robot import choose_parameters
from ..identification.selection import Prior, Selected, select_models
from ..results import CalibratedRobot
from ..studies import project_to_geometry, with_joint_offsets
from .options import SolveOptions


@dataclass(frozen=True)
class Fit:
    """The result of a fit, the same for both methods."""

    calibrated: CalibratedRobot
    optimizer: str
    seconds: float
    """Duration of the fit [s]."""
    iterates: tuple[CalibratedRobot, ...]
    """The robot after each iteration, the nominal one first."""
    covariance: np.ndarray | None = None
    """By the paper's method: how far the parameters would move if the same were recorded again,
    shape (n, n)."""
    selected: Selected | None = None
    """By the default method: the posterior, and why."""
    world: TiedRobots | None = None
    """All robots, of several that were calibrated together."""

    @cached_property
    def posterior(self) -> Posterior | None:
        """Posterior of the robot; None where it has none, or its covariance is not finite."""
        if self.selected is None:
            return None
        posterior = self.selected.full.arm
        return posterior if _is_covariance(posterior.covariance) else None


def _is_covariance(matrix: np.ndarray) -> bool:
    return bool(np.isfinite(matrix).all() and (np.diag(matrix) >= 0).all())


def fit_robots(
    robots: Sequence[RobotRecordings],
    options: SolveOptions,
    *,
    prior: Prior = None,
    require_scale: bool = True,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Fit]:
    """Fit one robot or several to their recordings; docs/model.md has the method.

    Args:
        robots: The nominal robots, and the placements to fit.
        options: Method and its options; coordinates only of sockets in the placements.
        prior: What an earlier calibration of a robot left known; see :func:`.prior_of`.
        require_scale: Refuse a placement none of whose sockets has a known distance to another.
        progress: Called with a word for each model that is fitted.

    Returns:
        A fit for each robot; those of several share one :attr:`Fit.world`.
    """
    options = options.validated()
    if options.method == "paper":
        return [_fit_by_paper(recordings, options) for recordings in robots]
    begin = time.perf_counter()
    places = places_of(
        robots,
        lengths=options.distances,
        sockets_at=options.located,
        deviation=options.deviation,
        require_scale=require_scale,
    )
    chosen = list[Selected]()
    visitors = list[Visitor]()
    for i, recordings in enumerate(robots):
        alone, sockets = places_alone(places, robots, i)
        selected = select_models(
            recordings,
            choose_parameters(recordings.robot, options.free, options.fix),
            observations_at(alone, recordings),
            without=options.without,
            zeros=bool(options.zeros),
            alike=options.as_recorded,
            prior=prior,
            curves=with_joint_curves,
            progress=lambda word, name=recordings.name: progress(
                f"{word} {name}".strip()
            ),
        )
        frame = places.frames.index(recordings.base_frame) if i else WORLD
        visitors.append(Visitor(recordings.name, frame, sockets, selected.full))
        chosen.append(selected)
    world = tie(visitors, places) if robots[0].name else None
    seconds = time.perf_counter() - begin
    fits = list[Fit]()
    tied = world.robots if world else visitors
    for recordings, selected, visitor in zip(robots, chosen, tied, strict=True):
        fit = _fit_of(recordings, replace(selected, full=visitor.fit), seconds)
        fits.append(replace(fit, world=world))
    return fits


def _fit_by_paper(recordings: RobotRecordings, options: SolveOptions) -> Fit:
    """Fit the geometry by Eq. (5) of the paper, see :mod:`mukca.solver.identification.paper`."""
    assert options.regularization is not None and options.max_iterations is not None
    robot = recordings.robot
    problem = build_problem(
        robot,
        recordings.measurements,
        parameters=choose_parameters(robot, options.free, options.fix),
        regularization=options.regularization,
    )
    optimizer = str(options.optimizer)
    begin = time.perf_counter()
    solution = solve(problem, optimizer, options.max_iterations)
    seconds = time.perf_counter() - begin
    calibrated = CalibratedRobot(
        robot, problem.parameters, solution.x, rotation_numbers="rpy"
    )
    iterates = tuple(replace(calibrated, values=x) for x in solution.iterates)
    return Fit(
        calibrated, optimizer, seconds, iterates, covariance(problem, solution.x)
    )


def _fit_of(arm: RobotRecordings, selected: Selected, seconds: float) -> Fit:
    posterior = selected.full.arm
    model = posterior.model
    deflection = posterior.deflection.beyond_zeros
    values = with_joint_offsets(posterior)
    exported = (
        project_to_geometry(posterior, arm.load) if deflection.extensions else None
    )
    calibrated = CalibratedRobot(
        arm.robot, model.parameters, values, deflection, arm.load, exported
    )
    iterates = tuple(
        replace(
            calibrated,
            values=model.values(x),
            deflection=model.deflection(x),
            exported=None,
        )
        for x in posterior.iterates
    )
    return Fit(calibrated, "gauss-newton", seconds, iterates, selected=selected)

"""Fits of several robots, each alone and then tied by what they share."""

import time
from collections.abc import Sequence

from ..bases import TiedRobots, Visitor, common_places, places_alone, tie
from ..identification import Progress
from ..identification.data import WORLD
from ..results import Fit
from .earlier import prior_of
from .fit import CalibrationProblem, fit_of, posterior_at
from .options import SolveOptions
from .robot_calibration import converged_fits
from .tables import METHODS


def tied_fits(
    robots: Sequence[CalibrationProblem], options: SolveOptions, progress: Progress
) -> tuple[list[Fit], TiedRobots]:
    """Return a fit of each robot, and all of them in one world.

    Raises:
        NotConverged: A fit did not converge; names an error in the recordings.
        FrameError: Nothing ties a robot or a frame to the first robot.
    """
    worlds: list[TiedRobots] = []

    def fitted() -> list[Fit]:
        begin = time.perf_counter()
        world = _tied(robots, options, progress)
        seconds = time.perf_counter() - begin
        worlds.append(world)
        fits: list[Fit] = []
        for arm, visitor in zip(robots, world.robots, strict=True):
            frames = () if fits else world.frames
            fits.append(fit_of(arm, visitor.fit, seconds, METHODS, frames))
        return fits

    return converged_fits(robots, fitted), worlds[0]


def _tied(
    robots: Sequence[CalibrationProblem], options: SolveOptions, progress: Progress
) -> TiedRobots:
    """Fit each robot to its recordings alone, then tie their bases by what they share.

    Args:
        robots: The nominal robots, and the placements to fit.
        options: Options of the fit; coordinates only of sockets in the placements.
        progress: Called with a word for each model that is fitted.
    """
    prior = prior_of(options, robots)
    options = options.validated()
    places = common_places(
        robots,
        lengths=options.distances,
        sockets_at=options.located,
        deviation=options.deviation,
    )
    visitors: list[Visitor] = []
    for i, arm in enumerate(robots):
        alone, sockets = places_alone(places, robots, i)

        posterior = posterior_at(
            alone,
            arm,
            options,
            METHODS,
            prior,
            lambda word, name=arm.name: progress(f"{word} {name}"),
        )
        frame = places.frames.index(arm.base_frame) if i else WORLD
        visitors.append(Visitor(arm.name, frame, sockets, posterior))
    return tie(visitors, places)

"""The calibration of several robots, which recorded at the same bases."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain

from ...recorder import Placement
from ..bases import TiedRobots, Visitor, base_name, common_places, places_alone, tie
from ..identification import Progress
from ..identification.data import WORLD, SocketAt, check_distinct
from ..identification.robot import Robot
from ..results import Fit
from ..tables import in_placements
from .calibration import Calibration
from .document import document_of
from .earlier import prior_of
from .fit import CalibrationProblem, fit_of, posterior_at
from .multi_robot_calibration import MultiRobotCalibration, common_document
from .options import SolveOptions, UsageError
from .preparation import Recordings, as_list, problem_of
from .robot_calibration import converged_fits
from .tables import CHECKS, METHODS, PROOF, STUDIES


def problems_of(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit by the robots' names; one robot alone has none."""
    if isinstance(robot, Mapping):
        return problems_of_robots(robot, train, test, options)
    return {"": problem_of(robot, train, test, options, CHECKS)}


def located_in_training(
    problems: Mapping[str, CalibrationProblem], options: SolveOptions
) -> list[SocketAt]:
    """Return coordinates of sockets in the placements of several robots to train on."""
    bases: dict[str, list[str]] = {"train": [], "test": []}
    for role, measured in chain(*(problem.placements for problem in problems.values())):
        bases[role].append(base_name(measured, len(problems)))
    return in_placements(options.located, bases["train"], bases["test"])


def problems_of_robots(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit to several robots."""
    _check_robots(robots, options)
    training = _by_robot(robots, train)
    held_out = _by_robot(robots, test)
    placements = list(chain(*training.values(), *held_out.values()))
    options.check_names(placements)
    problems: dict[str, CalibrationProblem] = {}
    for name, robot in robots.items():
        if not training[name]:
            names = ", ".join(robots)
            raise UsageError(
                f"{name}: no placement to train on; the robots are {names}"
            )
        problems[name] = problem_of(
            robot, training[name], held_out[name], options, CHECKS, name
        )
    # The same samples given to two arms would fit both, so refuse them.
    rows = chain.from_iterable(problem.placements for problem in problems.values())
    check_distinct([measured for _, measured in rows])
    return problems


def _check_robots(robots: Mapping[str, Robot], options: SolveOptions) -> None:
    """Refuse options that several robots cannot have."""
    if options.method != "auto":
        raise UsageError(
            "several robots: --method paper knows one, --method auto knows both"
        )
    for socket in options.located:
        if socket.frame == "base":
            raise UsageError(
                f"{socket.where}: the base of which robot? Write {next(iter(robots))}:base"
            )


def _by_robot(
    robots: Mapping[str, Robot], placements: Recordings
) -> dict[str, list[Placement]]:
    """Return each robot's placements: as given by name, or as each of them says."""
    by_robot: dict[str, list[Placement]] = {name: [] for name in robots}
    listing = ", ".join(robots)
    pairs: list[tuple[str | None, Placement]] = []
    if isinstance(placements, Mapping):
        for name, group in placements.items():
            pairs += [(name, placement) for placement in as_list(group)]
    else:
        pairs += [
            (placement.robot_name, placement) for placement in as_list(placements)
        ]
    for name, placement in pairs:
        where = placement.where
        if name is None:
            raise UsageError(
                f"{where}: which robot recorded it? Write NAME:{where}; the robots are {listing}"
            )
        if name not in by_robot:
            raise UsageError(
                f"{where}: of robot {name!r}, but the robots are {listing}"
            )
        if any(p.place == placement.place for p in by_robot[name]):
            raise UsageError(
                f"{where}: robot {name} has two placements called {placement.place!r}; rename a "
                "folder, since placements of one name are one base for all robots"
            )
        by_robot[name].append(placement)
    return by_robot


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
        fits, world = _tied_fits(robots, options, progress)
        worlds.append(world)
        return fits

    return converged_fits(robots, fitted), worlds[0]


def _tied_fits(
    robots: Sequence[CalibrationProblem], options: SolveOptions, progress: Progress
) -> tuple[list[Fit], TiedRobots]:
    """Fit each robot to its recordings alone, then tie their bases by what they share.

    Args:
        robots: The nominal robots, and the placements to fit.
        options: Options of the fit; coordinates only of sockets in the placements.
        progress: Called with a word for each model that is fitted.
    """
    prior = prior_of(options, robots)
    options = options.validated()
    begin = time.perf_counter()
    places = common_places(
        robots,
        lengths=options.distances,
        sockets_at=options.located,
        deviation=options.deviation,
    )
    visitors = list[Visitor]()
    for i, arm in enumerate(robots):
        alone, sockets = places_alone(places, robots, i)

        def said(word: str, name: str = arm.name) -> None:
            progress(f"{word} {name}")

        posterior = posterior_at(alone, arm, options, METHODS, prior, said)
        frame = places.frames.index(arm.base_frame) if i else WORLD
        visitors.append(Visitor(arm.name, frame, sockets, posterior))
    world = tie(visitors, places)
    seconds = time.perf_counter() - begin
    fits = list[Fit]()
    for arm, visitor in zip(robots, world.robots, strict=True):
        frames = () if fits else world.frames
        fits.append(fit_of(arm, visitor.fit, seconds, METHODS, frames))
    return fits, world


def calibrate_robots(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
    progress: Progress,
) -> MultiRobotCalibration:
    """Calibrate several robots by name; arguments are those of :func:`.calibrate_robot`."""
    problems = problems_of_robots(robots, train, test, options)
    located = located_in_training(problems, options)
    settings = replace(options, sockets_at=located)
    fits, world = tied_fits([*problems.values()], settings, progress)
    calibrations: dict[str, Calibration] = {}
    for (name, problem), fit in zip(problems.items(), fits, strict=True):
        proven = PROOF(problem, fit, progress=progress)
        document = document_of(proven, fit, STUDIES)
        calibrations[name] = Calibration(document, fit.calibrated)
    return MultiRobotCalibration(calibrations, common_document(calibrations, world))

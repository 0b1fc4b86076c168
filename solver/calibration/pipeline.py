"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import wraps
from inspect import signature
from operator import attrgetter
from textwrap import fill
from typing import Any, ParamSpec, Protocol, cast, get_type_hints, overload

import numpy as np

from ...recorder import Placement
from ..data import Measurement, RobotRecordings, in_placements
from ..paper import NotConverged
from ..robot import Robot
from .calibration import Calibration
from .fit import Fit, fit_robots
from .multi_robot_calibration import MultiRobotCalibration
from .options import SolveOptions, UsageError, check_keywords, option_table
from .problem import CalibrationProblem, as_list, prepare
from .results import document_of

Recordings = Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""
Progress = Callable[[str], None]
"""Called with a word for each model that is fitted."""
Keywords = ParamSpec("Keywords")


def _silent(_: str) -> None:
    pass


class Calibrate(Protocol[Keywords]):
    """Type of :func:`calibrate`: its keywords are the fields of :class:`SolveOptions`."""

    @overload
    def __call__(
        self,
        robot: Robot,
        train: Placement | Sequence[Placement],
        test: Placement | Sequence[Placement] = (),
        progress: Progress = _silent,
        *_: Keywords.args,
        **options: Keywords.kwargs,
    ) -> Calibration: ...

    @overload
    def __call__(
        self,
        robot: Mapping[str, Robot],
        train: Recordings,
        test: Recordings = (),
        progress: Progress = _silent,
        *_: Keywords.args,
        **options: Keywords.kwargs,
    ) -> MultiRobotCalibration: ...


def _taking(
    options: Callable[Keywords, SolveOptions],
) -> Callable[[Callable[..., Any]], Calibrate[Keywords]]:
    """Return a decorator: the fields of the options become keywords, and are documented."""

    def decorate(function: Callable[..., Any]) -> Calibrate[Keywords]:
        @wraps(function)
        def call(
            robot: Any, train: Any, test: Any = (), progress: Progress = _silent, **given: Any
        ) -> Any:
            check_keywords("calibrate", given, [one.name for one in (*own, *keywords)])
            return function(robot, train, test, progress, options(**given))  # pyright: ignore

        types = get_type_hints(options)
        *own, _ = signature(function).parameters.values()
        own[2:] = [p.replace(default=call.__defaults__[i]) for i, p in enumerate(own[2:])]  # pyright: ignore
        fields = signature(options).parameters.values()
        keywords = [field.replace(annotation=types[field.name]) for field in fields]
        call.__signature__ = signature(function).replace(parameters=[*own, *keywords])  # pyright: ignore
        head, _, end = (function.__doc__ or "").partition("        options: ")
        call.__doc__ = head + _documented() + end[end.index("\n") :]
        return cast("Any", call)

    return decorate


def _documented() -> str:
    """Return the options as they stand under ``Args:``."""
    rows = [
        f"{name}: {f'({option.method}) ' if option.method else ''}{option.help}."
        for name, option in option_table().items()
    ]
    return "\n".join(
        fill(row, 100, initial_indent=8 * " ", subsequent_indent=12 * " ") for row in rows
    )


@_taking(SolveOptions)
def calibrate(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    progress: Progress,
    options: SolveOptions,
) -> Calibration | MultiRobotCalibration:
    """Calibrate a robot from recordings.

    One placement is enough to calibrate; others, held out by ``test``, show how well it worked.
    Nothing is written before :meth:`Calibration.save`.

    Args:
        robot: The nominal robot, see :func:`mukca.load_robot`; or several robots by name, which
            recorded at the same bases, so that their relative base poses are calibrated, too.
        train: The placements to fit, see :func:`mukca.read_placements`. Of several robots they are
            given by name, too, and those of one base have one name.
        test: Placements that the fit does not see. One that is trained on is left out of them.
        progress: Called with a word for each model that is fitted.
        options: Each field of :class:`SolveOptions` by its name.

    Raises:
        UsageError: An option that cannot be, or belongs to the other method.
        MeasurementError: A placement does not hold what is needed.
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates that cannot be, or a frame that nothing ties to the robot.
        NotConverged: The fit did not converge.
    """
    options = options.validated()
    if not isinstance(robot, Mapping):
        if isinstance(train, Mapping) or isinstance(test, Mapping):
            raise UsageError("placements by the names of robots need robots by name, too")
        ((calibration, _),) = _calibrate({"": robot}, {"": train}, {"": test}, options, progress)
        return calibration
    _check_robots(robot, options)
    training, held_out = _by_robot(robot, train), _by_robot(robot, test)
    empty = next((name for name, own in training.items() if not own), None)
    if empty is not None:
        raise UsageError(f"{empty}: no placement to train on; the robots are {', '.join(robot)}")
    pairs = _calibrate(robot, training, held_out, options, progress)
    posterior = pairs[0][1].joint_posterior
    assert posterior is not None
    calibrations = {name: one for name, (one, _) in zip(robot, pairs, strict=True)}
    return MultiRobotCalibration(calibrations, posterior)


def _calibrate(
    robots: Mapping[str, Robot],
    train: Mapping[str, Placement | Sequence[Placement]],
    test: Mapping[str, Placement | Sequence[Placement]],
    options: SolveOptions,
    progress: Progress,
) -> list[tuple[Calibration, Fit]]:
    """Calibrate robots together; one robot is the case n = 1."""
    problems = [prepare(robot, train[name], test[name], options) for name, robot in robots.items()]
    alone = len(robots) == 1
    trained, held_out = (
        [_base_of(m, alone=alone) for problem in problems for m in part(problem)]
        for part in (attrgetter("train"), attrgetter("test"))
    )
    located = in_placements(options.located, trained, held_out)
    recordings = [
        RobotRecordings(problem.robot, problem.train, options.load, name)
        for name, problem in zip(robots, problems, strict=True)
    ]
    fits = _converged(
        lambda: fit_robots(recordings, replace(options, sockets_at=located), progress=progress),
        problems,
    )
    return [
        (Calibration(document_of(problem, fit), fit.calibrated), fit)
        for problem, fit in zip(problems, fits, strict=True)
    ]


def _base_of(measured: Measurement, *, alone: bool) -> str:
    """Return the name of a base: of several robots, placements of one name share it."""
    return measured.name if alone else measured.placement.place


def _check_robots(robots: Mapping[str, Robot], options: SolveOptions) -> None:
    """Refuse options that several robots cannot have."""
    if options.method != "auto":
        raise UsageError("several robots: --method paper knows one, --method auto knows both")
    for one in options.located:
        if one.frame == "base":
            raise UsageError(
                f"{one.where}: the base of which robot? Write {next(iter(robots))}:base"
            )


def _by_robot(robots: Mapping[str, Robot], placements: Recordings) -> dict[str, list[Placement]]:
    """Return each robot's placements: as given by name, or as each of them says."""
    by_robot: dict[str, list[Placement]] = {name: [] for name in robots}
    named = ", ".join(robots)
    if isinstance(placements, Mapping):
        pairs = [(name, p) for name, own in placements.items() for p in as_list(own)]
    else:
        pairs = [(p.robot_name, p) for p in as_list(placements)]
    for name, placement in pairs:
        where = placement.path or placement.name
        if name is None:
            raise UsageError(f"{where}: whose is it? Write NAME:{where}; the robots are {named}")
        if name not in by_robot:
            raise UsageError(f"{where}: of robot {name!r}, but the robots are {named}")
        if any(p.place == placement.place for p in by_robot[name]):
            raise UsageError(
                f"{where}: robot {name} has two placements called {placement.place!r}; rename a "
                "folder, since placements of one name are one base for all robots"
            )
        by_robot[name].append(placement)
    return by_robot


def _converged(fit: Callable[[], list[Fit]], problems: Sequence[CalibrationProblem]) -> list[Fit]:
    """Return fits that converged to finite numbers; else name an error in the recordings."""
    findings = [f for p in problems if p.inspected is not None for f in p.inspected.findings]
    wrong = next((finding for finding in findings if finding.level == "error"), None)
    try:
        fits = fit()
    except NotConverged:
        if wrong is None:
            raise
        raise NotConverged(f"the fit did not converge; {wrong}") from None
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"the fit did not converge ({error}); run mukca check") from None
    if not all(np.isfinite(one.calibrated.values).all() for one in fits):
        raise NotConverged("the fit did not converge: its numbers are not finite; run mukca check")
    return fits

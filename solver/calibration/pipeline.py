"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from inspect import signature
from textwrap import fill
from typing import Any, ParamSpec, Protocol, cast, get_type_hints, overload

import numpy as np

from ...recorder.dataset import Placement
from ..data import RobotRecordings, SocketAt, in_placements
from ..paper import NotConverged
from ..robot import Robot, choose_parameters
from .arms import ArmsCalibration
from .calibration import Calibration
from .fit import Fit, fit_arms, fit_by_auto, fit_by_paper
from .options import SolveOptions, option_table
from .prepare import as_list, prepare
from .problem import CalibrationProblem
from .results import compose
from .type_prior import type_priors
from .usage import UsageError

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
    ) -> ArmsCalibration: ...


def _taking(
    options: Callable[Keywords, SolveOptions],
) -> Callable[[Callable[..., Any]], Calibrate[Keywords]]:
    """Return a decorator: the fields of the options become keywords, and are documented."""

    def decorate(function: Callable[..., Any]) -> Calibrate[Keywords]:
        @wraps(function)
        def call(
            robot: Any, train: Any, test: Any = (), progress: Progress = _silent, **given: Any
        ) -> Any:
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
) -> Calibration | ArmsCalibration:
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
    settings = options.validated()
    located = settings.located
    if isinstance(robot, Mapping):
        return _calibrate_arms(robot, train, test, settings, located, progress)
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    task = prepare(robot, train, test, settings, located)
    names = ([m.name for m in part] for part in (task.train, task.test))
    fit = _fit(task, in_placements(located, *names), progress)
    return Calibration(compose(task, fit), fit.calibrated)


def _calibrate_arms(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    settings: SolveOptions,
    located: Sequence[SocketAt],
    progress: Callable[[str], None],
) -> ArmsCalibration:
    """Calibrate several robots together; see :func:`calibrate`."""
    if settings.method != "auto":
        raise UsageError("several robots: --method paper knows one, --method auto knows both")
    for one in located:
        if one.frame == "base":
            raise UsageError(
                f"{one.where}: the base of which robot? Write {next(iter(robots))}:base"
            )
    training, held_out = _by_robot(robots, train), _by_robot(robots, test)
    empty = next((name for name in robots if not training[name]), None)
    if empty is not None:
        raise UsageError(f"{empty}: no placement to train on; the robots are {', '.join(robots)}")
    tasks = {
        name: prepare(robot, training[name], held_out[name], settings, located)
        for name, robot in robots.items()
    }
    every = list(tasks.values())
    places = [m.placement.place for task in every for m in task.train]
    judged = [m.placement.place for task in every for m in task.test]
    arms = [RobotRecordings(t.robot, t.train, settings.load, name) for name, t in tasks.items()]
    parameters = [choose_parameters(r, settings.free, settings.fix) for r in robots.values()]
    types = type_priors(settings.type_prior, [arm.robot for arm in arms])
    options = {k: v for k, v in _of_auto(settings).items() if k != "load"}
    fits = _settled(
        lambda: fit_arms(
            arms,
            parameters,
            sockets_at=in_placements(located, places, judged),
            types=types,
            progress=progress,
            **options,
        ),
        every,
    )
    assert fits[0].world is not None
    calibrations = {
        name: Calibration(compose(task, fit), fit.calibrated)
        for (name, task), fit in zip(tasks.items(), fits, strict=True)
    }
    return ArmsCalibration(calibrations, fits[0].world)


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


def _fit(
    task: CalibrationProblem, located: Sequence[SocketAt], progress: Callable[[str], None]
) -> Fit:
    settings = task.settings
    parameters = choose_parameters(task.robot, settings.free, settings.fix)
    if settings.method == "paper":
        return _settled(
            lambda: [fit_by_paper(task.robot, parameters, task.train, **_of_paper(settings))],
            [task],
        )[0]
    options = _of_auto(settings)
    (of_type,) = type_priors(settings.type_prior, [task.robot])
    return _settled(
        lambda: [
            fit_by_auto(
                task.robot,
                parameters,
                task.train,
                **options,
                of_type=of_type,
                sockets_at=located,
                progress=progress,
            )
        ],
        [task],
    )[0]


def _settled(fit: Callable[[], list[Fit]], tasks: Sequence[CalibrationProblem]) -> list[Fit]:
    """Return fits, if they settled to finite numbers; else say what is wrong in the recordings."""
    findings = [f for task in tasks if task.inspected is not None for f in task.inspected.findings]
    wrong = next((finding for finding in findings if finding.level == "error"), None)
    try:
        fits = fit()
    except NotConverged:
        if wrong is None:
            raise
        raise NotConverged(f"the fit did not settle; {wrong}") from None
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"the fit did not settle ({error}); run mukca check") from None
    if not all(np.isfinite(one.calibrated.values).all() for one in fits):
        raise NotConverged("the fit did not settle: its numbers are not finite; run mukca check")
    return fits


def _of_paper(settings: SolveOptions) -> dict[str, Any]:
    return {
        name: getattr(settings, name) for name in ("optimizer", "regularization", "max_iterations")
    }


def _of_auto(settings: SolveOptions) -> dict[str, Any]:
    return {
        "known": settings.distances,
        "distance_deviation": settings.deviation,
        "load": settings.load,
        "without": settings.without,
        "zeros": bool(settings.zeros),
    }

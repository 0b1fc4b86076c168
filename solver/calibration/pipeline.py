"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from inspect import signature
from operator import attrgetter
from textwrap import fill
from typing import Any, ParamSpec, Protocol, cast, get_type_hints, overload

import numpy as np

from ...recorder import Placement
from ..data import base_name, in_placements
from ..paper import NotConverged
from ..robot import Robot
from .calibration import Calibration
from .fit import Fit, fit_robots
from .multi_robot_calibration import MultiRobotCalibration, common_document
from .options import SolveOptions, check_keywords, option_table
from .problem import CalibrationProblem, Recordings, problems_of
from .results import document_of

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
    """Return a decorator: a function's further keywords are these options, and documented."""

    def decorate(function: Callable[..., Any]) -> Calibrate[Keywords]:
        types = get_type_hints(options)
        *own, _ = signature(function).parameters.values()
        fields = signature(options).parameters.values()
        keywords = [field.replace(annotation=types[field.name]) for field in fields]
        function.__signature__ = signature(function).replace(parameters=[*own, *keywords])  # pyright: ignore
        head, _, end = (function.__doc__ or "").partition("        given: ")
        function.__doc__ = head + _documented() + end[end.index("\n") :]
        return cast("Any", function)

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
    test: Recordings = (),
    progress: Progress = _silent,
    **given: Any,
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
        given: Each field of :class:`SolveOptions` by its name.

    Raises:
        UsageError: An option that cannot be, or belongs to the other method.
        MeasurementError: A placement does not hold what is needed.
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates that cannot be, or a frame that nothing ties to the robot.
        NotConverged: The fit did not converge.
    """
    check_keywords("calibrate", given, signature(calibrate).parameters)
    options = SolveOptions(**given).validated()
    problems = problems_of(robot, train, test, options)
    bases = [
        [base_name(m, len(problems)) for problem in problems.values() for m in part(problem)]
        for part in (attrgetter("measurements"), attrgetter("test"))
    ]
    options = replace(options, sockets_at=in_placements(options.located, *bases))
    fits = _converged([*problems.values()], options, progress)
    calibrations = {
        name: Calibration(document_of(problem, fit), fit.calibrated)
        for (name, problem), fit in zip(problems.items(), fits, strict=True)
    }
    if not isinstance(robot, Mapping):
        return calibrations[""]
    assert fits[0].selected is not None  # the paper's method knows one robot
    together = common_document(calibrations, fits[0].selected.full)
    return MultiRobotCalibration(calibrations, together)


def _converged(
    problems: Sequence[CalibrationProblem], options: SolveOptions, progress: Progress
) -> list[Fit]:
    """Return fits that converged to finite numbers; else name an error in the recordings."""
    findings = [finding for problem in problems for finding in problem.checks]
    wrong = next((finding for finding in findings if finding.level == "error"), None)
    try:
        fits = fit_robots(problems, options, progress=progress)
    except NotConverged:
        if wrong is None:
            raise
        raise NotConverged(f"the fit did not converge; {wrong}") from None
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"the fit did not converge ({error}); run mukca check") from None
    if not all(np.isfinite(one.calibrated.values).all() for one in fits):
        raise NotConverged("the fit did not converge: its numbers are not finite; run mukca check")
    return fits

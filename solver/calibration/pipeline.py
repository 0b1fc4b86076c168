"""From recordings to a calibration: check, fit, measure the errors; and cross-validation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from inspect import signature
from operator import attrgetter
from textwrap import fill
from typing import Any, ParamSpec, Protocol, cast, get_type_hints, overload

import numpy as np

from ...recorder import Placement, Sample
from ..data import Measurement, RobotRecordings, base_name, in_placements
from ..diagnostics import named
from ..paper import NotConverged
from ..results import PlacementErrors
from ..robot import Robot
from .calibration import Calibration
from .errors import placement_errors
from .fit import Fit, fit_robots
from .multi_robot_calibration import MultiRobotCalibration
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
    problems = problems_of(robot, train, test, options)
    recordings = [
        RobotRecordings(problem.robot, problem.train, options.load, name)
        for name, problem in problems.items()
    ]
    bases = [
        [base_name(m, len(problems)) for problem in problems.values() for m in part(problem)]
        for part in (attrgetter("train"), attrgetter("test"))
    ]
    options = replace(options, sockets_at=in_placements(options.located, *bases))
    fits = _converged(
        lambda: fit_robots(recordings, options, progress=progress), [*problems.values()]
    )
    calibrations = {
        name: Calibration(document_of(problem, fit), fit.calibrated)
        for (name, problem), fit in zip(problems.items(), fits, strict=True)
    }
    if not isinstance(robot, Mapping):
        return calibrations[""]
    assert fits[0].joint_posterior is not None  # the paper's method knows one robot
    return MultiRobotCalibration.of(calibrations, fits[0].joint_posterior)


def _converged(fit: Callable[[], list[Fit]], problems: Sequence[CalibrationProblem]) -> list[Fit]:
    """Return fits that converged to finite numbers; else name an error in the recordings."""
    findings = [finding for problem in problems for finding in problem.checks]
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


@dataclass(frozen=True)
class Job:
    """One fit of a cross-validation. Its errors are then measured at all placements."""

    kind: str
    """``left_out``: trained on all placements but one; ``alone``: on one; ``bootstrap``: on all,
    with samples drawn anew from them."""
    trained: tuple[int, ...]
    """Indices of the placements that it is trained on."""
    seed: int | None = None
    """Of the random draw, for a bootstrap."""


def jobs(count: int, bootstrap: int = 0) -> list[Job]:
    """Return all fits for a number of placements, with ``bootstrap`` fits to resampled data."""
    everything = tuple(range(count))
    left_out = [Job("left_out", everything[:i] + everything[i + 1 :]) for i in everything]
    alone = [Job("alone", (i,)) for i in everything]
    again = [Job("bootstrap", everything, seed) for seed in range(bootstrap)]
    return [*(left_out if count > 1 else []), *alone, *again]


def run_job(problem: CalibrationProblem, job: Job) -> list[PlacementErrors] | None:
    """Fit, and return the errors at every placement; None if the fit did not converge."""
    train = [problem.train[i] for i in job.trained]
    if job.seed is not None:
        generator = np.random.default_rng(job.seed)
        train = [_resampled(measured, generator) for measured in train]
    names = {measured.name for measured in train}
    known = named(problem.train, problem.options.distances)
    options = replace(
        problem.options, known=[k for k in known if {k.first[0], k.second[0]} <= names]
    )
    recordings = RobotRecordings(problem.robot, train, options.load)
    try:
        fit = fit_robots([recordings], options, require_scale=False)[0]
    except NotConverged:
        return None
    models = fit.calibrated.models
    return [
        placement_errors(fit.calibrated, models, "train" if i in job.trained else "test", measured)
        for i, measured in enumerate(problem.train)
    ]


def _resampled(measured: Measurement, generator: np.random.Generator) -> Measurement:
    """Return a placement with as many samples drawn from its own (the bootstrap)."""
    drawn: list[Sample] = []
    for socket in measured.sockets:
        samples = [s for s in measured.placement.samples if s.socket == socket]
        picks = generator.integers(len(samples), size=len(samples))
        drawn += [samples[i] for i in picks.tolist()]
    return replace(measured, placement=replace(measured.placement, samples=tuple(drawn)))

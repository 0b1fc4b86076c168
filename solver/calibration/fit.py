"""The problem of a calibration, and the fit of one robot, by the paper's method or by default."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .. import identification, results
from ..identification import data
from ..identification.data import Load, Places, RobotRecordings, places_of
from ..identification.inference import FitPosterior, Posterior, with_joint_offsets
from ..identification.paper import REGULARIZATION, build_problem, covariance, solve
from ..identification.robot import choose_parameters
from ..results import CalibratedRobot, Fit, FramePose, Place, ball_of
from .options import SolveOptions


@dataclass(frozen=True, kw_only=True)
class CalibrationProblem(results.Measurements):
    """A robot, checked recordings of it, and the options of their fit."""

    options: SolveOptions
    warnings: tuple[str, ...] = ()
    checks: tuple[results.Diagnostic, ...] = ()
    """Diagnostics of the recordings, from before the fit."""
    hypotheses: tuple[results.Hypothesis, ...] = ()
    """Explanations of the recordings, the most probable first."""
    next_placement: results.NextPlacement | None = None
    """None where an instrument measured all samples."""

    def at_rest(
        self, shifts: np.ndarray | None, calibrated: results.CalibratedRobot
    ) -> "CalibrationProblem":
        """Return the recordings with what differs between their places, row by row."""
        if shifts is None:
            return self
        ends = np.cumsum([len(m.positions) for m in self.measurements])
        # orientations come last
        parts = zip(self.measurements, np.split(shifts, ends), strict=False)
        train = tuple(replace(m, moved=shift) for m, shift in parts)
        return replace(self, measurements=train)


@dataclass(frozen=True)
class Methods:
    """Methods beside the fit of an arm's own unknowns, which a calibration can do without."""

    curves: identification.CurveFit | None = None
    """The fit of error curves of the joints."""
    geometry: Callable[[Posterior, Load], np.ndarray] | None = None
    """The geometry for programs that do not correct joint positions, shape (n,) [m, rad]."""


NO_METHODS = Methods()


def fit_robot(
    arm: RobotRecordings,
    options: SolveOptions,
    methods: Methods,
    *,
    prior: identification.Prior = None,
    require_scale: bool = True,
    progress: identification.Progress = lambda _: None,
) -> Fit:
    """Fit one robot to its recordings; docs/model.md has the method.

    Args:
        arm: The nominal robot, and the placements to fit.
        options: Method and its options; coordinates only of sockets in the placements.
        methods: Error curves, and the geometry that is exported.
        prior: What an earlier calibration of the robot left known.
        require_scale: Refuse a placement none of whose sockets has a known distance to another.
        progress: Called with a word for each model that is fitted.
    """
    options = options.validated()
    if options.method == "paper":
        return _fit_by_paper(arm, options)
    begin = time.perf_counter()
    places = places_of(
        arm.measurements,
        lengths=options.distances,
        sockets_at=options.located,
        deviation=options.deviation,
        require_scale=require_scale,
    )
    full = posterior_at(places, arm, options, methods, prior, progress)
    return fit_of(arm, full, time.perf_counter() - begin, methods)


def posterior_at(
    places: Places,
    arm: RobotRecordings,
    options: SolveOptions,
    methods: Methods,
    prior: identification.Prior,
    progress: identification.Progress,
) -> FitPosterior:
    """Return the posterior of a robot that was recorded at places; see :func:`fit_robot`."""
    fit_options = identification.FitOptions(
        parameters=choose_parameters(arm.robot, options.free, options.fix),
        places=places,
        load=arm.load,
        effects=arm.effects,
        without=options.without,
        zeros=bool(options.zeros),
        alike=options.as_recorded,
        prior=prior,
        curves=methods.curves,
        progress=progress,
    )
    return identification.fit(arm.robot, arm.measurements, fit_options)


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


def fit_of(
    arm: RobotRecordings,
    full: FitPosterior,
    seconds: float,
    methods: Methods,
    frames: tuple[FramePose, ...] | None = None,
) -> Fit:
    """Return the fit that a posterior is of; its arguments are fields of :class:`.Fit`."""
    posterior = full.arm
    model = posterior.model
    deflection = posterior.deflection.beyond_zeros
    values = with_joint_offsets(posterior)
    exported = None
    if methods.geometry is not None and deflection.extensions:
        exported = methods.geometry(posterior, arm.load)
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
    return Fit(calibrated, "gauss-newton", seconds, iterates, full=full, frames=frames)


def ball_refitted(problem: CalibrationProblem) -> Place | None:
    """Return the ball's place alone, fitted to the nominal robot; None if it is not identified."""
    robot = problem.robot
    paired = [m for m in problem.measurements if m.has_distance]
    if paired:
        regularization = problem.options.regularization or REGULARIZATION
        equations = build_problem(
            robot, paired, parameters=ball_of(robot), regularization=regularization
        )
        return data.as_point(solve(equations).x)
    by_frame: dict[str, list[data.TipSamples]] = {}
    for m in problem.measurements:
        if m.kind == "points":
            tips = CalibratedRobot(robot).tips(m)
            by_frame.setdefault(m.frame, []).append(tips)
    if not by_frame:
        return None
    frames = [
        data.TipSamples(*map(np.concatenate, zip(*parts, strict=True)))
        for parts in by_frame.values()
    ]
    origin = data.Pose.of(robot.ball_joint.origin)
    return data.as_point(origin.apply(data.tip_shift(frames)))

"""Fits a robot to placements, by the paper's method or by the default one."""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..bayes.inference import JointPosterior, Posterior
from ..bayes.model import Expected
from ..bayes.model.effects import EXTENSIONS
from ..bayes.results import project_to_geometry, with_joint_offsets
from ..bayes.selection import Selected, select_models
from ..data import (
    CALIPER_DEVIATION,
    KnownDistance,
    Load,
    Measurement,
    RobotRecordings,
    SocketAt,
    observe_all,
)
from ..paper import MAX_ITERATIONS, REGULARIZATION, NotConverged, build_problem, covariance, solve
from ..results import CalibratedRobot
from ..robot import BallModel, Parameter, Robot

Predict = Callable[[Measurement], np.ndarray]
"""A model as a function: takes a placement, returns its N ball centres, shape (N, 3) [m]."""


@dataclass(frozen=True)
class Fit:
    """The result of a fit, the same for both methods."""

    calibrated: CalibratedRobot
    optimizer: str
    seconds: float
    """How long the fit took [s]."""
    iterates: tuple[Predict, ...]
    """The model after each iteration, the nominal one first."""
    posterior: Posterior | None = None
    """How well everything is known; None by the paper's method, which does not say."""
    choices: tuple[str, ...] | None = None
    """One line for each extension (compliance, tilt, ..): kept or not, and why. None by the
    paper's method, which has none."""
    world: JointPosterior | None = None
    """All robots that were fitted together, and the frames; None by the paper's method."""
    covariance: np.ndarray | None = None
    """By the paper's method: how far the parameters would move if the same were recorded again,
    shape (n, n)."""

    @property
    def iterations(self) -> int:
        """Number of steps taken."""
        return len(self.iterates) - 1


def fit_by_paper(
    robot: Robot,
    parameters: Sequence[Parameter],
    train: Sequence[Measurement],
    *,
    optimizer: str = "gauss-newton",
    regularization: float = REGULARIZATION,
    max_iterations: int = MAX_ITERATIONS,
) -> Fit:
    """Fit the geometry by Eq. (5) of the paper, see :mod:`mukca.solver.paper.costs`.

    Args:
        robot: The nominal robot.
        parameters: What of its geometry is free.
        train: The placements, each with two sockets.
        optimizer: ``gauss-newton`` or ``ipopt``; both reach the same minimum.
        regularization: lambda of Eq. (5).
        max_iterations: Steps allowed.

    Raises:
        SettingError: An optimizer or a regularization that cannot be.
        NotConverged: The optimizer gave up.
    """
    problem = build_problem(robot, train, parameters=parameters, regularization=regularization)
    begin = time.perf_counter()
    solution = solve(problem, optimizer, max_iterations)
    seconds = time.perf_counter() - begin
    calibrated = CalibratedRobot(robot, problem.parameters, solution.x)
    iterates = tuple(partial(_rigid, problem.model, x) for x in solution.iterates)
    return Fit(calibrated, optimizer, seconds, iterates, covariance=covariance(problem, solution.x))


def _rigid(model: BallModel, x: np.ndarray, measured: Measurement) -> np.ndarray:
    return model.points(x, measured.positions)


def fit_by_auto(
    robot: Robot,
    parameters: Sequence[Parameter],
    train: Sequence[Measurement],
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    distance_deviation: float = CALIPER_DEVIATION,
    load: Load | None = None,
    without: Sequence[str] = (),
    zeros: bool = False,
    of_type: Mapping[str, Expected] | None = None,
    require_scale: bool = True,
    progress: Callable[[str], None] = lambda _: None,
) -> Fit:
    """Fit geometry, elasticity and transmission error, as far as the data support them.

    docs/model.md introduces the method; :mod:`mukca.solver.bayes` is it.

    Args:
        robot: The nominal robot.
        parameters: What of its geometry is free.
        train: The placements.
        known: Measured distances beside those between each placement's first two sockets.
        sockets_at: Measured coordinates of sockets.
        distance_deviation: Standard deviation of a base's distance [m].
        load: What pulls at the joints; None for gravity alone, straight down.
        without: Among ``compliance``, ``tilt``, ``play``, ``transmission`` and ``joint-noise``:
            what is not tried.
        zeros: Whether the joints' zeros may be off by degrees, as on arms made of servos.
        of_type: Elasticity of other arms of the type, see
            :attr:`mukca.solver.bayes.model.extended_model.ExtendedModel.of_type`.
        require_scale: Refuse a placement none of whose sockets has a known distance to another.
        progress: Called with a word for each model that is fitted.

    Raises:
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates do not fit them, or a frame is not tied to the robot.
        NotConverged: A fit did not settle.
    """
    arm = RobotRecordings(robot, train, load or Load())
    return fit_arms(
        [arm],
        [parameters],
        known=known,
        sockets_at=sockets_at,
        distance_deviation=distance_deviation,
        without=without,
        zeros=zeros,
        types=[of_type] if of_type else [],
        require_scale=require_scale,
        progress=progress,
    )[0]


def fit_arms(
    arms: Sequence[RobotRecordings],
    parameters: Sequence[Sequence[Parameter]],
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    distance_deviation: float = CALIPER_DEVIATION,
    without: Sequence[str] = (),
    zeros: bool = False,
    types: Sequence[Mapping[str, Expected]] = (),
    require_scale: bool = True,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Fit]:
    """Fit several robots together; arguments as for :func:`fit_by_auto`, parameters robot by robot.

    Returns:
        A fit for each robot. They share one :attr:`Fit.world`.
    """
    begin = time.perf_counter()
    scene = observe_all(
        arms,
        known=known,
        sockets_at=sockets_at,
        deviation=distance_deviation,
        require_scale=require_scale,
    )
    chosen = select_models(
        [(arm.robot, free) for arm, free in zip(arms, parameters, strict=True)],
        scene,
        stages=[name for name in EXTENSIONS if name not in without],
        joint_noise="joint-noise" not in without,
        zeros=zeros,
        types=types,
        progress=progress,
    )
    seconds = time.perf_counter() - begin
    return [
        _fit_of(arm, free, chosen, i, seconds)
        for i, (arm, free) in enumerate(zip(arms, parameters, strict=True))
    ]


def _fit_of(
    arm: RobotRecordings, parameters: Sequence[Parameter], chosen: Selected, i: int, seconds: float
) -> Fit:
    full = chosen.full.arms[i]
    deflection, exported = full.deflection.without_joint_offsets, _exported(arm, full)
    calibrated = CalibratedRobot(
        arm.robot,
        tuple(parameters),
        with_joint_offsets(full) if deflection.extensions else exported,
        deflection,
        arm.load,
        exported if deflection.extensions else None,
    )
    iterates = tuple(partial(_extended, full, arm.load, x) for x in full.iterates)
    return Fit(
        calibrated, "gauss-newton", seconds, iterates, full, chosen.notes[i], world=chosen.full
    )


def _exported(arm: RobotRecordings, full: Posterior) -> np.ndarray:
    """Return the best geometry for a program that corrects nothing."""
    data, train = full.data, arm.measurements
    more = data.located or data.frames
    more = more or any(not k.on_base or k.deviation > CALIPER_DEVIATION for k in data.known)
    alone = None
    if not more and full.deflection.joint_offsets is None and all(m.has_distance for m in train):
        # else the paper's cost does not know all that is known
        with suppress(NotConverged):
            alone = fit_by_paper(arm.robot, full.model.parameters, train).calibrated.values
    return project_to_geometry(full, arm.load, alone)


def _extended(full: Posterior, load: Load, x: np.ndarray, measured: Measurement) -> np.ndarray:
    torques = load.torques(full.model.robot, measured)
    return full.model.predict(x, measured.positions, torques)

"""The fit of one robot to its measurements, with the choice of effects beyond its geometry."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .data import (
    STANDARD_LOAD,
    Load,
    Measurement,
    Observations,
    Places,
    RobotRecordings,
    observations_at,
    places_of,
)
from .effects import CURVE, EFFECTS, EXTENSIONS, effects_of
from .inference import FitPosterior, estimate, refit
from .model import (
    ExtendedModel,
    GivenPrior,
    extend,
)
from .robot import Parameter, Robot, choose_parameters
from .selection import (
    ModelChoice,
    beside_curves,
    choose_models,
    joint_offsets_in_words,
    search,
    set_ups,
    with_differences,
)

JOINT_NOISE = "joint-noise"
"""Named beside the extensions: the noise of the joints."""
HELD = 1e-8
"""Deviation of a joint's zero that is held [rad]."""
Progress = Callable[[str], None]
"""Called with a word for each model that is fitted."""
Prior = GivenPrior | None
"""What an earlier calibration of the robot left known."""
CurveFit = Callable[
    [FitPosterior, tuple[FitPosterior, float] | None, Progress],
    tuple[FitPosterior, str],
]
"""Adds error curves of the joints to a posterior where the data support them, and says why."""


def _silent(_: str) -> None:
    pass


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """Options of :func:`fit`; the defaults do for an arm that was recorded in sockets."""

    parameters: Sequence[Parameter] | None = None
    """The free numbers of the robot's geometry; None for all."""
    places: Places | None = None
    """Where the samples were recorded; None for the distance that each placement states."""
    load: Load = STANDARD_LOAD
    """Gravity and payload while recording."""
    effects: Sequence[str] = ()
    """Coefficients of rare effects that the recordings show before any fit, by name."""
    without: Collection[str] = ()
    """Extensions that are not tried; without ``joint-noise`` joints' angles are exact."""
    zeros: bool = False
    """True if joint offsets may be degrees, as in arms made of servos."""
    alike: bool = False
    """True if nothing may differ between places."""
    prior: Prior = None
    """What an earlier calibration of the robot left known."""
    curves: CurveFit | None = None
    """The fit of error curves beside everything else; None for no curves."""
    progress: Progress = _silent


def fit(
    robot: Robot,
    measurements: Sequence[Measurement],
    options: FitOptions = FitOptions(),
) -> FitPosterior:
    """Fit the geometry of a robot, then try extension after extension.

    The most probable unknowns minimise the objective L of docs/model.md, (A1); an extension counts
    by its evidence (A6).

    Args:
        robot: The nominal robot.
        measurements: Its placements.
        options: What is free, what is known already, and what is tried.

    Returns:
        The mean of the models that the data support, that of the geometry alone without any; its
        notes say of each extension whether it was kept.

    Raises:
        NotConverged: The fit of the geometry did not settle.
        KnownError: A placement whose sockets have no known distance to others.
        FrameError: Nothing ties a frame to the robot, or its coordinates cannot be.
    """
    recordings = RobotRecordings(robot, measurements, options.load, options.effects)
    data = observations_at(options.places or places_of(measurements), recordings)
    first = effects_of(zeros=options.zeros)
    options.progress("geometry")
    geometric = _geometric_fit(
        _geometric_model(recordings, first, options), data, options
    )
    stages = _stages(first, options.without)
    scalar = [name for name in stages if name != CURVE.extension]
    searched = search(geometric, scalar, options.progress)
    if not options.alike:
        differences = with_differences(searched.best).objective.differences
        if differences != geometric.objective.differences:
            geometric = refit(geometric, differences=differences, average_widths=False)
            searched = search(geometric, scalar, options.progress)
    choice = choose_models(searched.models)
    mean = result = choice.mean
    curves_note = ""
    if options.curves is not None and CURVE.extension in stages:
        alternative = beside_curves(mean, searched.models)
        result, curves_note = options.curves(mean, alternative, options.progress)
    if result.active != mean.active:
        choice = ModelChoice([result], "; beside curves")
    notes = choice.notes(searched.gains)
    if curves_note:
        notes.append(f"{CURVE.extension}: {curves_note}")
    if options.zeros:
        notes.append(joint_offsets_in_words(result.arm))
    return replace(result, notes=tuple(notes))


def _geometric_fit(
    model: ExtendedModel, data: Observations, options: FitOptions
) -> FitPosterior:
    """Return the fit of the geometry, with targets that differ from set-up to set-up."""
    return estimate(
        model,
        data,
        joint_noise=JOINT_NOISE not in options.without,
        differences=() if options.alike else set_ups(data),
        average_widths=False,
    )


def _geometric_model(
    recordings: RobotRecordings, first: Sequence[str], options: FitOptions
) -> ExtendedModel:
    """Return the model before any extension: the geometry, and effects that are there anyway.

    These are the first ones, and but for curves, those that an earlier calibration tells of or that
    the recordings show.
    """
    robot, prior = recordings.robot, options.prior
    parameters = options.parameters
    if parameters is None:
        parameters = choose_parameters(robot)
    names = {*recordings.effects, *(prior.names if prior else ())}
    effects = [*first]
    for effect in EFFECTS.values():
        coefficients = effect.coefficient_names(robot.joint_names)
        if effect is not CURVE and not names.isdisjoint(coefficients):
            effects.append(effect.name)
    model = extend(robot, parameters, effects)
    if prior is None and options.zeros:
        prior = _without_zeros(robot, parameters)
    return replace(model, given=prior, seen=recordings.effects)


def _without_zeros(robot: Robot, parameters: Sequence[Parameter]) -> Prior:
    """Return what holds the zeros that a URDF cannot: of slides, and where angles are not free."""
    angles = [p.joint for p in parameters if p.unit == "rad"]
    joints = [
        joint.name
        for joint in robot.actuated
        if joint.type == "prismatic" or angles.count(joint.name) < 3
    ]
    names = EFFECTS["zero"].coefficient_names(joints)
    count = len(names)
    return GivenPrior(tuple(names), np.zeros(count), HELD**2 * np.eye(count))


def _stages(first: Sequence[str], without: Collection[str]) -> list[str]:
    """Return the extensions to try, all of whose effects stand alone or beside the first ones."""
    stages: list[str] = []
    for name, effects in EXTENSIONS.items():
        required = {EFFECTS[effect].requires for effect in effects}
        if name not in without and required <= {"", *first}:
            stages.append(name)
    return stages

"""Decides by the data which extensions of the geometry to keep, and how much each counts."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from ...studies import joint_offsets_in_words
from ..data import Observations, RobotRecordings
from ..effects import CURVE, EFFECTS, EXTENSIONS, effects_of
from ..inference import FitPosterior, estimate, refit
from ..model import ExtendedModel, GivenPrior, extend
from ..robot import Parameter
from .differences import with_differences
from .model_averaging import beside_curves
from .model_choice import ModelChoice, choose_models
from .model_search import search

JOINT_NOISE = "joint-noise"
"""Named beside the extensions: the noise of the joints."""
Progress = Callable[[str], None]
"""Called with a word for each model that is fitted."""
Prior = GivenPrior | None
"""What an earlier calibration of the robot left known."""
CurveFit = Callable[
    [FitPosterior, tuple[FitPosterior, float] | None, Progress],
    tuple[FitPosterior, str],
]
"""Adds error curves of the joints to a result where the data support them, and says why; see
:func:`.with_joint_curves`."""


@dataclass(frozen=True)
class Selected:
    """The models that the data chose."""

    full: FitPosterior
    """The mean of the models that the data support; that of the geometry alone without any."""
    notes: tuple[str, ...]
    """One line for each extension: kept or not, and the evidence."""


def select_models(
    recordings: RobotRecordings,
    parameters: Sequence[Parameter],
    data: Observations,
    *,
    without: Collection[str] = (),
    zeros: bool = False,
    alike: bool = False,
    prior: Prior = None,
    curves: CurveFit | None = None,
    progress: Progress = lambda _: None,
) -> Selected:
    """Calibrate the geometry of a robot, then try extension after extension.

    Args:
        recordings: The nominal robot, and its placements.
        parameters: The free numbers of the robot's geometry.
        data: Training placements.
        without: Extensions that are not tried; without ``joint-noise`` joints' angles are exact.
        zeros: True if joint offsets may be degrees, as in arms made of servos.
        alike: True if nothing may differ between places.
        prior: What an earlier calibration of the robot left known.
        curves: The fit of error curves beside everything else; None for no curves.
        progress: Called with a word for each model that is fitted.

    Raises:
        NotConverged: The fit of the geometry did not settle.
    """
    progress("geometry")
    first = effects_of(zeros=zeros)
    geometric = estimate(
        _geometric_model(recordings, parameters, first, prior),
        data,
        joint_noise=JOINT_NOISE not in without,
        average_widths=False,
    )
    stages = _stages(first, without)
    scalar = [name for name in stages if name != CURVE.extension]
    searched = search(geometric, scalar, progress)
    if not alike:
        differences = with_differences(searched.best).objective.differences
        if differences:
            geometric = refit(geometric, differences=differences, average_widths=False)
            searched = search(geometric, scalar, progress)
    choice = choose_models(searched.models)
    mean = result = choice.mean
    curves_note = ""
    if curves is not None and CURVE.extension in stages:
        alternative = beside_curves(mean, searched.models)
        result, curves_note = curves(mean, alternative, progress)
    if result.active != mean.active:
        choice = ModelChoice([result], "; beside curves")
    notes = choice.notes(searched.gains)
    if curves_note:
        notes.append(f"{CURVE.extension}: {curves_note}")
    if zeros:
        notes.append(joint_offsets_in_words(result.arm))
    return Selected(result, tuple(notes))


def _geometric_model(
    recordings: RobotRecordings,
    parameters: Sequence[Parameter],
    first: Sequence[str],
    prior: Prior,
) -> ExtendedModel:
    """Return the model before any extension: the geometry, and effects that are there anyway.

    These are the first ones, and but for curves, those that an earlier calibration tells of or that
    the recordings show.
    """
    names = {*recordings.effects, *(prior.names if prior else ())}
    effects = [*first]
    for effect in EFFECTS.values():
        coefficients = effect.coefficient_names(recordings.robot.joint_names)
        if effect is not CURVE and not names.isdisjoint(coefficients):
            effects.append(effect.name)
    model = extend(recordings.robot, parameters, effects)
    return replace(model, given=prior, seen=recordings.effects)


def _stages(first: Sequence[str], without: Collection[str]) -> list[str]:
    """Return the extensions to try, all of whose effects stand alone or beside the first ones."""
    stages: list[str] = []
    for name, effects in EXTENSIONS.items():
        required = {EFFECTS[effect].requires for effect in effects}
        if name not in without and required <= {"", *first}:
            stages.append(name)
    return stages

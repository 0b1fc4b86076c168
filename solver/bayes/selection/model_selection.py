"""Decides by the data which extensions of the geometry to keep, and how much each counts."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from ...data import Observations, RobotRecordings
from ...robot import Parameter
from ..inference import FitPosterior, estimate, refit, with_joint_curves
from ..model import (
    Expected,
    ExtendedModel,
    GivenPrior,
    Prior,
    differences_of,
    extend,
)
from ..model.effects import CURVE, EFFECTS, EXTENSIONS, effects_of
from ..results import joint_offsets_in_words
from .model_averaging import beside_curves
from .model_choice import ModelChoice, choose_models
from .model_search import SearchedModels, models_by_type, search
from .moved_places import FoundMovement, movements_by_evidence

JOINT_NOISE = "joint-noise"
"""Named beside the extensions: the noise of the joints."""


@dataclass(frozen=True)
class Selected:
    """The models that the data chose."""

    full: FitPosterior
    """The mean of the models that the data support; that of the geometry alone without any."""
    notes: tuple[str, ...]
    """One line for each extension: kept or not, and the evidence."""
    movements: tuple[FoundMovement, ...] = ()
    """Movements of placements while they were recorded, also those too unsure for the model."""


def select_models(
    recordings: RobotRecordings,
    parameters: Sequence[Parameter],
    data: Observations,
    *,
    without: Collection[str] = (),
    zeros: bool = False,
    prior: Prior = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Selected:
    """Calibrate the geometry of a robot, then try extension after extension.

    Args:
        recordings: The nominal robot, and its placements.
        parameters: The free numbers of the robot's geometry.
        data: Training placements.
        without: Extensions that are not tried; without ``joint-noise`` joints' angles are exact.
        zeros: True if joint offsets may be degrees, as in arms made of servos.
        prior: The elasticity of other arms of the robot's type, to be tried, too; or what an
            earlier calibration of the robot left known.
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
        movements=differences_of(recordings),
        average_widths=False,
    )
    stages = _stages(first, without)
    of_type = _of_type(prior, stages)
    scalar = [name for name in stages if name != CURVE.extension]
    searched, movements = _search_beside_movements(geometric, scalar, progress)
    by_type = models_by_type(searched.fits, of_type, progress)
    choice = choose_models([*searched.models, *by_type])
    mean = result = choice.mean
    curves_note = ""
    if CURVE.extension in stages:
        alternative = beside_curves(mean, searched.models)
        result, curves_note = with_joint_curves(mean, alternative, progress)
    if result.active != mean.active:
        choice = ModelChoice([result], "; beside curves")
    notes = choice.notes(searched.gains)
    if of_type:
        notes.append(choice.type_note)
    if curves_note:
        notes.append(f"{CURVE.extension}: {curves_note}")
    if zeros:
        notes.append(joint_offsets_in_words(result.arm))
    return Selected(result, tuple(notes), movements)


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
    earlier = prior if isinstance(prior, GivenPrior) else None
    names = {*recordings.effects, *(earlier.names if earlier else ())}
    effects = [*first]
    for effect in EFFECTS.values():
        coefficients = effect.coefficient_names(recordings.robot.joint_names)
        if effect is not CURVE and not names.isdisjoint(coefficients):
            effects.append(effect.name)
    model = extend(recordings.robot, parameters, effects)
    return replace(model, given=earlier, seen=recordings.effects)


def _stages(first: Sequence[str], without: Collection[str]) -> list[str]:
    """Return the extensions to try, all of whose effects stand alone or beside the first ones."""
    stages: list[str] = []
    for name, effects in EXTENSIONS.items():
        required = {EFFECTS[effect].requires for effect in effects}
        if name not in without and required <= {"", *first}:
            stages.append(name)
    return stages


def _of_type(prior: Prior, stages: Sequence[str]) -> Mapping[str, Expected]:
    """Return what other arms of the type tell of effects that are tried."""
    if prior is None or isinstance(prior, GivenPrior):
        return {}
    tried = {effect for stage in stages for effect in EXTENSIONS[stage]}
    return {name: expected for name, expected in prior.items() if name in tried}


def _search_beside_movements(
    geometric: FitPosterior,
    stages: Sequence[str],
    progress: Callable[[str], None],
) -> tuple[SearchedModels, tuple[FoundMovement, ...]]:
    """Return the models, beside movements of places if the data support any, and these."""
    searched = search(geometric, stages, progress)
    movements, reported = movements_by_evidence(searched.best)
    if any(movement.kept for movement in reported):
        geometric = refit(geometric, movements=movements, average_widths=False)
        searched = search(geometric, stages, progress)
    return searched, reported

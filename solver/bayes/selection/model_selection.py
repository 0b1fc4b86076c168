"""Decides by the data which extensions of the geometry to keep, and how much each counts."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, compress
from math import log

import numpy as np

from ...data import Observations, RobotRecordings
from ...paper import NotConverged
from ...robot import Parameter, Robot
from ..inference import FitPosterior, estimate, refit, with_joint_curves
from ..model import Expected, GivenPrior, Prior, differences_of, extend
from ..model.effects import CURVE, EFFECTS, EXTENSIONS, effects_of
from ..results import joint_offsets_in_words
from .model_averaging import (
    averaged,
    beside_curves,
    held_out_errors,
    mean_fall,
    model_probabilities,
)
from .moved_places import FoundMovement, movements_by_evidence

LOG_BAYES_FACTOR = log(150)
"""Least rise of the logarithm of the evidence by all extensions together: what is called very
strong (Kass and Raftery 1995). Of 216 simulated arms without any, one raised it by as much; six by
log(20), for which errors of 48 that bend would be 2 % smaller after 10 + 10 samples."""
LIKELY = 0.01
"""Models less probable than this are left out of the mean."""
ENOUGH_PLACEMENTS = 3
NO_MASSES = "cannot be told without masses in the URDF, or measured torques"

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
    stages = {*EXTENSIONS, JOINT_NOISE} - {*without}
    earlier = prior if isinstance(prior, GivenPrior) else None
    first = effects_of(zeros=zeros)
    robot, differences = recordings.robot, differences_of(recordings)
    effects = _effects_of(robot, earlier, recordings.effects)
    base = extend(robot, parameters, (*first, *effects))
    model = replace(base, given=earlier, seen=recordings.effects)
    geometric = estimate(
        model, data, joint_noise=JOINT_NOISE in stages, movements=differences
    )
    names = [
        name
        for name in EXTENSIONS
        if name in stages and _required(name) <= {"", *first}
    ]
    scalar = [name for name in names if name != CURVE.extension]
    tryable = set(chain.from_iterable(EXTENSIONS[name] for name in names))
    of_type = dict[str, Expected]()
    if prior is not None and not isinstance(prior, GivenPrior):
        of_type = {
            name: expected for name, expected in prior.items() if name in tryable
        }
    tried = _search(geometric, scalar, progress)
    movements, reported = movements_by_evidence(max(tried.models, key=_evidence))
    if any(line.kept for line in reported):  # all again beside these
        tried = _search(refit(geometric, movements=movements), scalar, progress)
    choice = _supported([*tried.models, *_by_type(tried.fits, of_type, progress)])
    mean = result = choice.mean
    note = ""
    if CURVE.extension in stages:
        result, note = with_joint_curves(
            mean, beside_curves(mean, tried.models), progress
        )
    if result.active != mean.active:
        choice = _Choice([result], "; beside curves")
    notes = [
        f"{stage}: {choice.note(stage, gain)}" for stage, gain in tried.gains.items()
    ]
    if of_type:
        share = choice.share(lambda fit: bool(fit.model.of_type))
        notes.append(f"type prior: counts by {100 * share:.0f} %")
    if note:
        notes.append(f"{CURVE.extension}: {note}")
    if zeros:
        notes.append(joint_offsets_in_words(result.arm))
    return Selected(result, tuple(notes), reported)


def _evidence(model: FitPosterior) -> float:
    return model.log_evidence


def _required(extension: str) -> set[str]:
    return {EFFECTS[effect].requires for effect in EXTENSIONS[extension]}


def _effects_of(
    robot: Robot, prior: GivenPrior | None, seen: Collection[str]
) -> tuple[str, ...]:
    """Return the effects but curves that a prior tells of, or that recordings show."""
    names = {*seen, *(prior.names if prior is not None else ())}
    joints = robot.joint_names
    return tuple(
        effect.name
        for effect in EFFECTS.values()
        if effect is not CURVE and names & {*effect.coefficient_names(joints)}
    )


@dataclass(frozen=True)
class _Tried:
    """All that was tried."""

    models: list[FitPosterior]
    """The models, that of the geometry alone first."""
    gains: dict[str, float | None]
    """Rise of the logarithm of the evidence by each extension; None where the fit does not settle
    with it."""
    fits: list[FitPosterior]
    """All fits with extensions, also those that came out like another."""


def _search(
    geometric: FitPosterior, stages: Sequence[str], progress: Callable[[str], None]
) -> _Tried:
    """Add extension after extension to the best model; twice, since one may help beside another."""
    best, gains = geometric, dict[str, float | None]()
    models, tried = {best.active: best}, {best.model.extensions}
    fits = list[FitPosterior]()
    for stage in (*stages, *stages):
        extended = best.model.with_effects((*best.model.extensions, *EXTENSIONS[stage]))
        if extended.extensions in tried:
            continue
        tried.add(extended.extensions)
        progress(stage)
        try:
            candidate = refit(best, extended)
        except NotConverged:
            gains.setdefault(stage)
            continue
        fits.append(candidate)
        gain = gains[stage] = candidate.log_evidence - best.log_evidence
        if candidate.active not in models:
            candidate = models[candidate.active] = _without_idle(candidate)
            best = candidate if gain > 0 else best
    return _Tried(list(models.values()), gains, fits)


def _without_idle(fit: FitPosterior) -> FitPosterior:
    """Return a fit without effects that it holds at zero, as if they were known exactly."""
    idle = {group.name for group in fit.state.groups if not group.width}
    effects = {*fit.model.extensions} - idle
    return refit(fit, fit.model.with_effects(effects)) if idle else fit


def _by_type(
    fits: Sequence[FitPosterior],
    of_type: Mapping[str, Expected],
    progress: Callable[[str], None],
) -> list[FitPosterior]:
    """Return the fits again, with all that other arms of a type tell of, as they tell it."""
    models: dict[tuple[str, ...], FitPosterior] = {}
    for fit in fits if of_type else ():
        extended = fit.model.with_effects({*fit.model.extensions, *of_type})
        if extended.extensions not in models:
            progress("type prior")
            with suppress(NotConverged):
                like_type = refit(fit, replace(extended, of_type=of_type))
                models[extended.extensions] = _without_idle(like_type)
    return list({model.active: model for model in models.values()}.values())


@dataclass(frozen=True)
class _Choice:
    """The models that count."""

    models: Sequence[FitPosterior]
    reason: str = ""
    """Reason for which these count, in words."""

    @cached_property
    def probabilities(self) -> np.ndarray:
        """Probability of each model."""
        return model_probabilities(self.models)

    @property
    def mean(self) -> FitPosterior:
        """The mean of the models."""
        only, *others = self.models
        return averaged(self.models, self.probabilities) if others else only

    def share(self, counts: Callable[[FitPosterior], bool]) -> float:
        """Return the probability of all models that count."""
        return float(self.probabilities[[counts(model) for model in self.models]].sum())

    def note(self, extension: str, gain: float | None) -> str:
        """Return what became of an extension by which the evidence rose, in words."""
        effects = [EFFECTS[name] for name in EXTENSIONS[extension]]
        if not self.models[0].data.torques.any() and any(
            e.shared_by_type for e in effects
        ):
            return NO_MASSES
        if gain is None:
            return "not supported by the data (with it, the fit does not settle)"
        evidence = f"(log evidence {gain:+.1f})"
        probability = self.share(
            lambda fit: bool({*EXTENSIONS[extension]} & {*fit.active})
        )
        if not probability:
            return f"not supported by the data {evidence}{self.reason}"
        if probability > 1 - LIKELY:
            return f"kept {evidence}{self.reason}"
        weight = f"{100 * probability:.0f} % probable, averaged in with that weight"
        return f"kept: {weight} {evidence}{self.reason}"


def _supported(models: list[FitPosterior]) -> _Choice:
    """Return the models that count: the geometry alone, or the probable ones."""
    geometric, best = models[0], max(models, key=_evidence)
    if best.log_evidence - geometric.log_evidence < LOG_BAYES_FACTOR:
        return _Choice([geometric])
    reason = ""
    if len(best.data.placements) >= ENOUGH_PLACEMENTS:
        candidates = [m for m in models if not m.model.of_type]
        best_alone = max(candidates, key=_evidence)
        try:
            after = held_out_errors(best)
            if best is not best_alone:  # a type's prior has to lower errors, too
                before = held_out_errors(best_alone)
                if mean_fall(before, after)[0] <= 0:
                    models, after = candidates, before
            helps, spread = mean_fall(held_out_errors(geometric), after)
        except NotConverged:
            return _Choice(
                [geometric], "; the fit does not settle without each placement"
            )
        reason = (
            f"; where one placement is left out, all together lower errors by {1e3 * helps:.4f} "
            f"+- {1e3 * spread:.4f} mm"
        )
        if helps <= spread:
            return _Choice([geometric], reason)
    probable = compress(models, model_probabilities(models) > LIKELY)
    return _Choice([*probable], reason)

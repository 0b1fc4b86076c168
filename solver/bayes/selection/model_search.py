"""The search for extensions of the geometry: fits of more and more of them."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from ...paper import NotConverged
from ..inference import FitPosterior, refit
from ..model import Expected
from ..model.effects import EXTENSIONS


@dataclass(frozen=True)
class SearchedModels:
    """All that was tried."""

    models: list[FitPosterior]
    """The models, that of the geometry alone first."""
    gains: dict[str, float | None]
    """Rise of the logarithm of the evidence by each extension; None where the fit does not settle
    with it."""
    fits: list[FitPosterior]
    """All fits with extensions, also those that came out like another."""

    @property
    def best(self) -> FitPosterior:
        """The model of highest evidence."""
        return best_of(self.models)


def best_of(models: Sequence[FitPosterior]) -> FitPosterior:
    """Return the model of highest evidence."""
    return max(models, key=lambda model: model.log_evidence)


def search(
    geometric: FitPosterior,
    stages: Sequence[str],
    progress: Callable[[str], None],
) -> SearchedModels:
    """Add extension after extension to the best model; twice, since one may help beside another."""
    best = geometric
    models, tried = {best.active: best}, {best.model.extensions}
    gains: dict[str, float | None] = {}
    fits: list[FitPosterior] = []
    for stage in (*stages, *stages):
        extended = best.model.with_effects((*best.model.extensions, *EXTENSIONS[stage]))
        if extended.extensions in tried:
            continue
        tried.add(extended.extensions)
        progress(stage)
        try:
            candidate = refit(best, extended, average_widths=False)
        except NotConverged:
            gains.setdefault(stage)
            continue
        fits.append(candidate)
        gain = candidate.log_evidence - best.log_evidence
        gains[stage] = gain
        if candidate.active not in models:
            candidate = models[candidate.active] = _without_idle(candidate)
            best = candidate if gain > 0 else best
    return SearchedModels(list(models.values()), gains, fits)


def models_by_type(
    fits: Sequence[FitPosterior],
    of_type: Mapping[str, Expected],
    progress: Callable[[str], None],
) -> list[FitPosterior]:
    """Return the fits again, with all that other arms of a type tell of, as they tell it."""
    if not of_type:
        return []
    models: dict[tuple[str, ...], FitPosterior] = {}
    for fit in fits:
        extended = fit.model.with_effects({*fit.model.extensions, *of_type})
        if extended.extensions in models:
            continue
        progress("type prior")
        with suppress(NotConverged):
            model = replace(extended, of_type=of_type)
            like_type = refit(fit, model, average_widths=False)
            models[extended.extensions] = _without_idle(like_type)
    by_active = {model.active: model for model in models.values()}
    return list(by_active.values())


def _without_idle(fit: FitPosterior) -> FitPosterior:
    """Return a fit without effects that it holds at zero, as if they were known exactly."""
    idle = {group.name for group in fit.state.groups if not group.width}
    if not idle:
        return fit
    effects = {*fit.model.extensions} - idle
    model = fit.model.with_effects(effects)
    return refit(fit, model, average_widths=False)

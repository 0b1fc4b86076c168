"""The search for extensions of the geometry: fits of more and more of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ....errors import NotConverged
from ..effects import EXTENSIONS
from ..inference import FitPosterior, refit


@dataclass(frozen=True)
class SearchedModels:
    """All that was tried."""

    models: list[FitPosterior]
    """The models, that of the geometry alone first."""
    gains: dict[str, float | None]
    """Rise of the logarithm of the evidence by each extension; None where the fit does not settle
    with it."""

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
        gain = candidate.log_evidence - best.log_evidence
        gains[stage] = gain
        if candidate.active not in models:
            candidate = models[candidate.active] = _without_idle(candidate)
            best = candidate if gain > 0 else best
    return SearchedModels(list(models.values()), gains)


def _without_idle(fit: FitPosterior) -> FitPosterior:
    """Return a fit without effects that it holds at zero, as if they were known exactly."""
    idle = {group.name for group in fit.state.groups if not group.width}
    if not idle:
        return fit
    effects = {*fit.model.extensions} - idle
    model = fit.model.with_effects(effects)
    return refit(fit, model, average_widths=False)

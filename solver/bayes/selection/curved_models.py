"""Joint error curves, beside the model that is most probable with them."""

from collections.abc import Callable, Sequence
from math import log

import numpy as np

from ..inference import JointPosterior, may_have_curves, with_joint_curves
from ..model.effects import COMPLIANCE, CURVE, HARMONICS, TILT
from .model_averaging import log_odds, model_probabilities

HARMONICS_BESIDE_CURVES = log(150)
"""Least rise of the logarithm of the evidence by which harmonics stay: curves are such themselves.
It is what is called very strong (Kass and Raftery 1995)."""


def with_curves(
    found: JointPosterior, models: Sequence[JointPosterior], progress: Callable[[str], None]
) -> tuple[JointPosterior, str]:
    """Return a result with error curves of its joints where the data support them, and why.

    Args:
        found: The result without curves.
        models: All that were tried, of which one may be more probable beside curves.
        progress: Called with a word before they are tried.
    """
    if not may_have_curves(found):
        return found, ""
    progress(CURVE.extension)
    return with_joint_curves(found, _beside_curves(found, models))


def _beside_curves(
    found: JointPosterior, models: Sequence[JointPosterior]
) -> list[tuple[JointPosterior, float]]:
    """Return the model that may be more probable beside curves, and the logarithm of its odds.

    Errors that nothing explains yet hide elasticity, and harmonics stand for curves.
    """
    elastic, harmonics = {COMPLIANCE.name, TILT.name}, {one.name for one in HARMONICS}
    own, *others = (
        {group.name for arm in one.arms for group in arm.groups if group.width}
        for one in (found, *models)
    )
    if own & elastic and not own & harmonics:
        return []
    pairs = zip(models, others, strict=True)
    bent = [model for model, names in pairs if names & elastic and not names & harmonics]
    if not bent:
        return []
    best = bent[int(np.argmax(model_probabilities(bent)))]
    odds = log_odds(best) - log_odds(found)
    return [(best, odds + HARMONICS_BESIDE_CURVES if own & harmonics else odds)]

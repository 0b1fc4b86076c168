"""Size of the arm in explanations: a fit knows it better than the linear model of a comparison."""

from dataclasses import replace

from ..results import Hypothesis
from .hypotheses import KINDS, SIZE_BY_DISTANCE, sockets_by_share


def by_fit(hypothesis: Hypothesis, share: float) -> Hypothesis:
    """Return an explanation of the arm's size with the share by which a fit made it longer.

    One that explains no size, or that of an instrument's points, stays.
    """
    parameters = hypothesis.parameters
    if hypothesis.name not in SIZE_BY_DISTANCE or "likely" not in parameters:
        return hypothesis
    given = parameters["given"]
    assert isinstance(given, float)
    sized = {**parameters, **sockets_by_share(share, given)}
    kind = next(kind for kind in KINDS if kind.name == hypothesis.name)
    return replace(hypothesis, parameters=sized, text=kind.text(sized))

"""Rule by which the samples of a placement are enough, or more of them would hardly help."""

from typing import NamedTuple

from .sufficiency import Sufficiency


class End(NamedTuple):
    """End of a placement."""

    enough: bool
    """True if the samples are a calibration."""
    near_only: bool
    """True if that is so near the recorded places, and not yet in the whole workspace."""
    exhausted: bool
    """True if they are not, and more of them at this placement would hardly help."""


class StoppingRule:
    """Rule that does not take back that samples are enough while ``mukca solve`` agrees.

    ``near_suffices`` is False where the operator gave a goal, which stands.
    """

    def __init__(self, *, near_suffices: bool) -> None:
        self._near_suffices = near_suffices
        self._enough = False

    def end(
        self, solved: Sufficiency | None, *, exhausted: bool, reaches_goal: bool
    ) -> End:
        """Return the end by a verdict on all samples so far, None where a fault is seen.

        The first time, samples are enough by a margin, so that further ones do not take it back.
        Near the recorded places they are enough if no more can be had here, or once they were:
        more samples tell more of the noise, so that an error can be predicted larger.
        """
        passes = solved is not None and solved.enough and (solved.sized or self._enough)
        near = self._near_suffices and (exhausted or self._enough)
        self._enough = passes and (reaches_goal or near)
        return End(
            enough=self._enough,
            near_only=self._enough and not reaches_goal,
            exhausted=exhausted and not self._enough,
        )

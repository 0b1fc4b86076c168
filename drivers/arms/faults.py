"""Faults on demand: of the simulated arm, and of the emulated controllers."""

import math
import random
from collections.abc import Collection
from dataclasses import dataclass

ARM_FAULTS = ("drop", "silent", "freeze", "repeat", "nan", "jump", "zeros", "short", "push")
"""Kinds of faults of the simulated arm; the documentation's page on simulation describes each."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that lasts for a while."""

    kind: str
    share: float = 1.0
    """Share of the messages that it affects, above 0 and at most 1."""
    start: float = 0.0
    """Time at which it begins [s]."""
    duration: float = math.inf
    """[s]"""

    @classmethod
    def parse(
        cls, text: str, kinds: Collection[str] = ARM_FAULTS, duration: float = 0.5
    ) -> "Fault":
        """Return the fault that ``KIND[:SHARE][@START[+DURATION]]`` names, as in ``nan@3.5+0.2``.

        Args:
            text: The fault as it is written.
            kinds: Kinds that there are.
            duration: Duration where none is given [s].

        Raises:
            ValueError: The text names none.
        """
        what, _, when = text.partition("@")
        kind, _, share = what.partition(":")
        start, _, length = when.partition("+")
        try:
            fault = cls(kind, float(share or 1), float(start or 0), float(length or duration))
        except ValueError:
            raise ValueError(
                f"fault {text!r}: expected KIND[:SHARE][@START[+DURATION]], as in drop:0.05@2+3"
            ) from None
        if kind not in kinds or not 0 < fault.share <= 1:
            raise ValueError(
                f"fault {text!r}: the share is from 0 to 1, and the kind one of {', '.join(kinds)}"
            )
        return fault

    def is_active(self, moment: float) -> bool:
        """Return whether the fault lasts at a moment [s]."""
        return self.start <= moment < self.start + self.duration

    def affects(self, moment: float, generator: random.Random) -> bool:
        """Return whether the fault affects a message at a moment [s], by its share."""
        return self.is_active(moment) and (self.share == 1 or generator.random() < self.share)

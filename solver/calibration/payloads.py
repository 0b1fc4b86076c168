"""Payloads of an arm while it was recorded: one for all placements, and those of some."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...errors import PAYLOAD
from .option import UsageError

if TYPE_CHECKING:
    from ...recorder import Placement


@dataclass(frozen=True)
class Payloads:
    """Masses at the ball [kg]."""

    masses: Mapping[str, float]
    """By the placements that they belong to, an empty name for all others."""

    @staticmethod
    def read(words: float | str | Sequence[float | str] | None) -> "Payloads":
        """Return masses such as ``0.5`` and ``left=0.7``; UsageError for one that is none."""
        several = (
            words
            if isinstance(words, Sequence) and not isinstance(words, str)
            else [words]
        )
        masses: dict[str, float] = {}
        for item in several if words is not None else ():
            name, _, mass = str(item).rpartition("=")
            try:
                masses[name] = float(mass)
            except ValueError:
                masses[name] = -1.0
            if not 0 <= masses[name] <= PAYLOAD.largest:
                text = item if isinstance(item, str) else f"{item:g}"
                doubt = PAYLOAD.doubt([masses[name]]) if masses[name] > 0 else None
                reason = doubt or "give kilograms, zero or more"
                raise UsageError(f"--payload {text}: {reason}")
        return Payloads(masses)

    @property
    def of_others(self) -> float:
        """Mass of placements that are not named."""
        return self.masses.get("", 0.0)

    @property
    def words(self) -> float | tuple[str, ...] | None:
        """The masses as options have them: one number where no placement is named."""
        if set(self.masses) <= {""}:
            return self.masses.get("")
        return tuple(
            f"{name}={mass!r}".lstrip("=") for name, mass in self.masses.items()
        )

    def check(self, placements: "Iterable[Placement]") -> None:
        """Refuse a payload of a placement that is not there."""
        names = [(p.name, p.place) for p in placements]
        for name, mass in self.masses.items():
            if name and not any(name in pair for pair in names):
                listing = ", ".join(name for name, _ in names)
                raise UsageError(
                    f"--payload {name}={mass:g}: no such placement; there are {listing}"
                )

    def carried_by(
        self, placements: "Iterable[Placement]", *, others: bool = False
    ) -> "list[Placement]":
        """Return placements with the payloads that are stated of them.

        ``others``: the mass that names no placement is that of all which state none, too.
        """
        loaded: list[Placement] = []
        for placement in placements:
            mass = self.masses.get(placement.name, self.masses.get(placement.place))
            if others and mass is None and placement.payload is None:
                mass = self.masses.get("")
            loaded.append(
                placement if mass is None else replace(placement, payload=mass)
            )
        return loaded

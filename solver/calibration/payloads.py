"""Payloads of an arm while it was recorded: one for all placements, and those of some."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...errors import PAYLOAD
from .option import UsageError

if TYPE_CHECKING:
    from ...recorder import Placement


def read_payloads(words: float | str | Sequence[float | str] | None) -> dict[str, float]:
    """Return masses [kg] by the placements that they belong to, an empty name for all others.

    Raises:
        UsageError: A mass that is none.
    """
    several = words if isinstance(words, Sequence) and not isinstance(words, str) else [words]
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
    return masses


def written(masses: Mapping[str, float]) -> float | tuple[str, ...] | None:
    """Return payloads as options have them: one number where no placement is named."""
    if set(masses) <= {""}:
        return masses.get("")
    return tuple(f"{name}={mass!r}".lstrip("=") for name, mass in masses.items())


def check_payloads(placements: "Iterable[Placement]", masses: Mapping[str, float]) -> None:
    """Refuse a payload of a placement that is not there."""
    names = [(p.name, p.place) for p in placements]
    for name, mass in masses.items():
        if name and not any(name in pair for pair in names):
            listing = ", ".join(name for name, _ in names)
            raise UsageError(f"--payload {name}={mass:g}: no such placement; there are {listing}")


def carrying(
    placements: "Iterable[Placement]", masses: Mapping[str, float], *, others: bool = False
) -> "list[Placement]":
    """Return placements with their payloads, as :func:`read_payloads` gives them.

    ``others``: the mass that names no placement is that of all which state none, too.
    """
    loaded: list[Placement] = []
    for placement in placements:
        mass = masses.get(placement.name, masses.get(placement.place))
        if others and mass is None and placement.payload is None:
            mass = masses.get("")
        loaded.append(placement if mass is None else replace(placement, payload=mass))
    return loaded

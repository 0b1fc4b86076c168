"""Option of a calibration: its documentation, range and refusals; and payloads."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, cast

from ...errors import PAYLOAD, MukcaError

Method = Literal["auto", "paper"]


class UsageError(MukcaError):
    """Arguments that cannot be, or do not go together; in words that hold for Python, too."""


@dataclass(frozen=True)
class Option:
    """Documentation of an option, for the command line, Python and the docs alike."""

    text: str
    """One sentence or two: the value, its unit, its default."""
    metavar: str | tuple[str, ...] | None = None
    """Placeholder of the value on the command line; as many as there must be values."""
    group: str = "fit"
    """Title under which help lists it; ``method auto`` or ``method paper`` for one of a method."""
    default: Any = None
    """The value for which None, or an empty sequence, stands."""
    choices: tuple[str, ...] = ()
    repeated: bool = False
    """True where the option may be given several times, each with one value."""
    unit: str = ""
    """Of a number, in full: ``metres``."""
    within: tuple[float, float] | None = None
    """Least and largest number, or length of a vector."""

    @property
    def method(self) -> str | None:
        """The only method that knows the option."""
        return self.group.partition("method ")[2] or None

    def check(self, name: str, value: Any) -> None:
        """Refuse a value that cannot be."""
        words = f"--{name.replace('_', '-')}"
        if self.within is not None and not self._is_within(value):
            several = isinstance(value, tuple | list)
            numbers = cast("Sequence[Any]", value if several else [value])
            typed_numbers = " ".join(
                f"{x:g}" if isinstance(x, float) else str(x) for x in numbers
            )
            raise UsageError(f"{words} {typed_numbers}: give {self.unit}")
        for item in value if self.choices else ():
            if item not in self.choices:
                raise UsageError(
                    f"{words} {item}: choose among {', '.join(self.choices)}"
                )

    def _is_within(self, value: Any) -> bool:
        """Return whether a number is in its range; of a vector, its length, and its components."""
        low, high = self.within or (-math.inf, math.inf)
        try:
            if not isinstance(self.metavar, tuple):
                return bool(low <= value <= high)
            is_whole = len(value) == len(self.metavar)
            return is_whole and low <= math.hypot(*value) <= high
        except TypeError:  # text in place of a number
            return False


def joints_named(words: str, joints: Sequence[str]) -> tuple[str, ...]:
    """Return what ``--joints`` says that another program calls a model's joints.

    It has names between commas, or one word in which ``*`` is each of the model's names.
    """
    names = words.split(",")
    if "*" in words:
        names = [words.replace("*", joint) for joint in joints]
    if len(names) != len(joints):
        raise UsageError(
            f"--joints {words}: {len(names)} names, but the model has {len(joints)} joints: "
            f"{', '.join(joints)}"
        )
    return tuple(name.strip() for name in names)


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
        if words is None:
            return Payloads({})
        masses: dict[str, float] = {}
        for item in words if isinstance(words, tuple | list) else [words]:
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

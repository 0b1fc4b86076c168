"""Option of a calibration: its documentation and its range, and the refusal of what cannot be."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

from ...errors import MukcaError

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
        return (
            self.group.removeprefix("method ")
            if self.group.startswith("method ")
            else None
        )

    @property
    def help(self) -> str:
        """The text, with the default where there is one to name."""
        plain_value = isinstance(self.default, str | int | float) and not isinstance(
            self.default, bool
        )
        return f"{self.text} (default: {self.default})" if plain_value else self.text

    @property
    def described(self) -> str:
        """The help, and before it the method that alone knows the option."""
        return f"({self.method}) {self.help}" if self.method else self.help

    def check(self, name: str, value: Any) -> None:
        """Refuse a value that cannot be."""
        words = f"--{name.replace('_', '-')}"
        if self.within is not None and not self._is_within(value):
            numbers = cast(
                "Sequence[Any]", value if isinstance(value, tuple | list) else [value]
            )
            typed_numbers = " ".join(
                f"{x:g}" if isinstance(x, float) else str(x) for x in numbers
            )
            raise UsageError(f"{words} {typed_numbers}: give {self.unit}")
        unknown = (
            [item for item in value if item not in self.choices] if self.choices else []
        )
        if unknown:
            raise UsageError(
                f"{words} {unknown[0]}: choose among {', '.join(self.choices)}"
            )

    def _is_within(self, value: Any) -> bool:
        """Return whether a number is in its range; of a vector, its length, and its components."""
        low, high = self.within or (-math.inf, math.inf)
        try:
            if isinstance(self.metavar, tuple):
                return (
                    len(value) == len(self.metavar)
                    and low <= math.hypot(*value) <= high
                )
            return bool(low <= value <= high)
        except TypeError:  # text in place of a number
            return False


def joints_named(words: str, joints: Sequence[str]) -> tuple[str, ...]:
    """Return what ``--joints`` says that another program calls a model's joints.

    It has names between commas, or one word in which ``*`` is each of the model's names.
    """
    names = (
        words.split(",")
        if "*" not in words
        else [words.replace("*", j) for j in joints]
    )
    if len(names) != len(joints):
        raise UsageError(
            f"--joints {words}: {len(names)} names, but the model has {len(joints)} joints: "
            f"{', '.join(joints)}"
        )
    return tuple(name.strip() for name in names)

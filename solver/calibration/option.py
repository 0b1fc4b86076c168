"""Option of a calibration: its documentation and its range, and the refusal of what cannot be."""

from collections.abc import Callable, Sequence
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
    method: Method | None = None
    """The only method that knows the option."""
    default: Any = None
    """The value for which None, or an empty sequence, stands."""
    choices: tuple[str, ...] = ()
    unit: str = ""
    """Of a number, in full: ``metres``."""
    allowed: Callable[[Any], bool] | None = None
    """Range check of a value."""

    @property
    def help(self) -> str:
        """The text, with the default where there is one to name."""
        named = isinstance(self.default, str | int | float) and not isinstance(self.default, bool)
        return f"{self.text} (default: {self.default})" if named else self.text

    def check(self, name: str, value: Any) -> None:
        """Refuse a value that cannot be."""
        words = f"--{name.replace('_', '-')}"
        try:
            allowed = self.allowed is None or self.allowed(value)
        except TypeError:  # text in place of a number
            allowed = False
        if not allowed:
            numbers = cast("Sequence[Any]", value if isinstance(value, tuple | list) else [value])
            given = " ".join(f"{x:g}" if isinstance(x, float) else str(x) for x in numbers)
            raise UsageError(f"{words} {given}: give {self.unit}")
        unknown = [one for one in value if one not in self.choices] if self.choices else []
        if unknown:
            raise UsageError(f"{words} {unknown[0]}: choose among {', '.join(self.choices)}")


def joints_named(words: str, joints: Sequence[str]) -> tuple[str, ...]:
    """Return what ``--joints`` says that another program calls a model's joints.

    It has names between commas, or one word in which ``*`` is each of the model's names.
    """
    named = words.split(",") if "*" not in words else [words.replace("*", j) for j in joints]
    if len(named) != len(joints):
        raise UsageError(
            f"--joints {words}: {len(named)} names, but the model has {len(joints)} joints: "
            f"{', '.join(joints)}"
        )
    return tuple(name.strip() for name in named)

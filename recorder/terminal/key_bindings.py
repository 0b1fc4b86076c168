"""Bindings of keys to actions, also of a foot pedal's or a presenter's keys."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from ...errors import MukcaError
from .keyboard import NAMES

ACTIONS = ("capture", "undo", "redo", "delete", "relabel", "next", "finish", "help")
"""Actions that a key can be given."""
KEYS: Mapping[str, str] = {
    "space": "capture",
    "a": "capture",
    "d": "undo",
    "u": "undo",
    "r": "redo",
    "x": "delete",
    "l": "relabel",
    "s": "next",
    "q": "finish",
    "?": "help",
    "y": "yes",
    "n": "new",
    "k": "keep",
}
"""Default action of each key; digits choose a socket."""


class KeyMapError(MukcaError):
    """A key cannot be given this action."""


def keys_with(settings: Iterable[str]) -> dict[str, str]:
    """Return each key's action, with some given by the operator, as in ``capture=Enter,PageDown``.

    Raises:
        KeyMapError: No such action, or no such key.
    """
    keys = dict(KEYS)
    for setting in settings:
        action, _, names = setting.partition("=")
        if action not in ACTIONS:
            raise KeyMapError(f"--key {setting}: {action!r} is none of {', '.join(ACTIONS)}")
        for name in names.split(","):
            keys[_known(name, setting)] = action
    return keys


def capture_key(keys: Mapping[str, str]) -> str:
    """Return the name of the key that captures: the first that the operator chose, or space."""
    chosen = (key for key, does in keys.items() if does == "capture" and key not in KEYS)
    return next(chosen, "space")


def _known(name: str, setting: str) -> str:
    """Return a key by the keyboard's name for it."""
    by_lower = {known.lower(): known for known in NAMES}
    if name.lower() in by_lower:
        return by_lower[name.lower()]
    if len(name) == 1 and name.isprintable() and not name.isdigit() and name != " ":
        return name.lower()
    raise KeyMapError(
        f"--key {setting}: no key is called {name!r}; a character but a digit, or one of "
        f"{', '.join(sorted(NAMES))}"
    )


@dataclass(frozen=True)
class TypedLine:
    """A line that is being typed: the number of a sample, and what to do with it."""

    action: str
    """``delete`` or ``relabel``."""
    typed: str = ""

    @property
    def text(self) -> str:
        """The line as the operator sees it."""
        asks = {"delete": "delete sample", "relabel": "relabel: sample, blank, socket"}
        return f"{asks[self.action]}: {self.typed}_   Enter does it, q leaves"

    @property
    def numbers(self) -> list[int]:
        """Numbers typed so far."""
        return [int(word) for word in self.typed.split()]

    def with_key(self, key: str) -> "TypedLine":
        """Return the line after one more key."""
        if key == "Backspace":
            return replace(self, typed=self.typed[:-1])
        key = " " if key == "space" else key
        return replace(self, typed=self.typed + key) if key in "0123456789 " else self

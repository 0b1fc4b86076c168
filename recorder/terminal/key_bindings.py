"""Which key does what: the usual ones, and those that a foot pedal or a presenter sends."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from ...errors import MukcaError
from .keyboard import NAMES

ACTIONS = ("capture", "undo", "redo", "delete", "relabel", "next", "finish", "help")
"""What a key can be given to do."""
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
}
"""What each key does, where nothing else is said; digits choose a socket."""


class KeyMapError(MukcaError):
    """A key cannot be given what it should do."""


def keys_with(settings: Iterable[str]) -> dict[str, str]:
    """Return what each key does, with some given by the operator.

    Args:
        settings: Each like ``capture=Enter,PageDown``: what to do, and the keys that do it.

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
    """Return what to call the key that captures: the first that the operator chose, or space."""
    chosen = (key for key, does in keys.items() if does == "capture" and key not in KEYS)
    return next(chosen, "space")


def _known(name: str, setting: str) -> str:
    """Return a key as the keyboard calls it."""
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
class Prompt:
    """A line that is being typed: the number of a sample, and what to do with it."""

    action: str
    """``delete`` or ``relabel``."""
    typed: str = ""

    @property
    def text(self) -> str:
        """What the operator sees."""
        asks = {"delete": "delete sample", "relabel": "relabel: sample, blank, socket"}
        return f"{asks[self.action]}: {self.typed}_   Enter does it, q leaves"

    @property
    def numbers(self) -> list[int]:
        """What was typed so far."""
        return [int(word) for word in self.typed.split()]

    def with_key(self, key: str) -> "Prompt":
        """Return the prompt after one more key."""
        if key == "Backspace":
            return replace(self, typed=self.typed[:-1])
        key = " " if key == "space" else key
        return replace(self, typed=self.typed + key) if key in "0123456789 " else self

"""Bindings of keys to actions, of a foot pedal or a presenter as well, and scripts of keys."""

import os
import re
import select
import sys
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace

from ...errors import MukcaError
from ..session import KEYS
from .keyboard import NAMES, TABLES

ACTIONS = [*dict.fromkeys(KEYS.values())]
"""Actions that a key can be given."""


class KeyMapError(MukcaError):
    """A key cannot be given this action."""


def keys_with(settings: Iterable[str]) -> dict[str, str]:
    """Return each key's action, some given by the operator, as in ``capture=Enter,Tab,keep=Up``.

    Raises:
        KeyMapError: No such action or key, a key of two actions, or an action without a key.
    """
    chosen: dict[str, str] = {}
    for setting in settings:
        action = ""
        for i, part in enumerate(setting.split(",")):
            before, _, name = part.partition("=")
            if i == 0 or (before and name):
                action = before
            else:
                name = part
            if action not in ACTIONS:
                raise KeyMapError(
                    f"--key {setting}: {action!r} is none of {', '.join(ACTIONS)}"
                )
            by_lower = {name.lower(): name for name in NAMES}
            is_letter = len(name) == 1 and name.isprintable() and not name.isdigit()
            key = by_lower.get(name.lower(), name.lower() if is_letter else " ")
            if key == " ":
                raise KeyMapError(
                    f"--key {setting}: no key is called {name!r}; a character but a digit, or one "
                    f"of {', '.join(sorted(NAMES))}"
                )
            if chosen.setdefault(key, action) != action:
                raise KeyMapError(
                    f"--key {setting}: {name} is given to {chosen[key]} already; one action a key"
                )
    keys = {**KEYS, **chosen}
    keyless = [action for action in ACTIONS if action not in keys.values()]
    if keyless:
        raise KeyMapError(
            f"--key: no key is left for {keyless[0]}; give it one: --key {keyless[0]}=KEY"
        )
    return keys


ASKS = TABLES["asks"]
"""Words that ask for the numbers of each action that takes some."""
_NUMBER = re.compile(r"\d+\.?\d*|\.\d+")


@dataclass(frozen=True)
class TypedLine:
    """A line that is being typed: numbers, and what to do with them."""

    action: str
    """One of those in :data:`ASKS`."""
    typed: str = ""

    @property
    def text(self) -> str:
        """The line as the operator sees it."""
        return f"{ASKS[self.action]}: {self.typed}_   Enter does it, {{finish}} leaves"

    @property
    def numbers(self) -> list[float]:
        """Numbers typed so far; none where a word is no number."""
        words = self.typed.replace(",", ".").split()
        return list(map(float, words)) if all(map(_NUMBER.fullmatch, words)) else []

    def with_key(self, key: str) -> "TypedLine":
        """Return the line after one more key."""
        if key == "Backspace":
            return replace(self, typed=self.typed[:-1])
        key = " " if key == "space" else key
        return replace(self, typed=self.typed + key) if key in "0123456789., " else self


PATIENCE = 30.0
"""Longest wait of a step for the arm [s]."""
LONGEST_SCRIPT = 1_000_000
"""Letters that are read at once at most."""
_WORD = re.compile(r"(!?)([adurqs?0-9]+)(?:\*(\d{1,4}))?")
_NUMBERED = re.compile(r"delete=\d{1,5}|relabel=\d{1,5}:\d|measure=\d+\.?\d*")
_WAIT = re.compile(r"wait=(\d+\.?\d*|\.\d+)")


class ScriptError(MukcaError):
    """A script cannot be read, or waited too long for the arm."""

    def __init__(self, message: str, *, failed: bool = False) -> None:
        super().__init__(message)
        self.failed = failed


@dataclass(frozen=True, slots=True)
class Step:
    """One key press, or a pause."""

    key: str = ""
    at_once: bool = True
    """True to press the key without waiting for a new rest."""
    pause: float = 0.0
    """[s]"""


class Script:
    """The steps of a key script, read as they come from a file or pipe, not closed here.

    Raises:
        ScriptError: A first word that means nothing, or a script without end.
    """

    def __init__(self, descriptor: int, name: str = "standard input") -> None:
        self._descriptor = descriptor
        self.name = name
        self._steps: deque[Step] = deque()
        self._rest = ""
        self._read_all = False
        self._empty = True
        self._begun: tuple[float, float] | None = None
        self.read()

    def fileno(self) -> int:
        """The descriptor to wait on."""
        return self._descriptor

    @property
    def hungry(self) -> bool:
        """True while more is to be read before the script can go on."""
        return not (self._steps or self._read_all)

    @property
    def over(self) -> bool:
        """True once nothing is left to do."""
        return not self._steps and self._read_all

    def due(self, now: float, stamp: float, trouble: str | None) -> str | None:
        """Return the next key if its time has come, and go on to the step after it."""
        while self._steps:
            self._begun = self._begun or (now, stamp)
            step = self._steps[0]
            paused = stamp - self._begun[1] >= step.pause
            if not paused or (trouble and not step.at_once):
                if now - self._begun[0] > PATIENCE + step.pause:
                    reason = f"the arm came to no new rest ({trouble})"
                    if not step.key:
                        reason = "no state came"
                    raise ScriptError(
                        f"{self.name}: waited {PATIENCE:g} s, but {reason}; what was captured is "
                        "saved",
                        failed=True,
                    )
                return None
            self._begun = None
            self._steps.popleft()
            if step.key:
                return step.key
        return None

    def read(self) -> None:
        """Read all that there is; call it when the descriptor is ready.

        Raises:
            ScriptError: A word that means nothing, or a script without end.
        """
        while not self._read_all and (
            sys.platform == "win32" or select.select([self], [], [], 0)[0]
        ):
            data = os.read(self._descriptor, 65536)
            self._read_all = not data
            self._rest += data.decode(errors="replace")
            if len(self._rest) > LONGEST_SCRIPT:  # a device has no end
                raise ScriptError(
                    f"{self.name}: over {LONGEST_SCRIPT:,} letters are no key script"
                )
        *lines, self._rest = self._rest.split("\n")
        if self._read_all:
            lines.append(self._rest)
            self._rest = ""
        for line in lines:
            for word in line.partition("#")[0].split():
                self._steps.extend(self._parse(word))
                self._empty = False
        if self._read_all and self._empty:
            raise ScriptError(
                f"{self.name} holds no keys; run it in a terminal, or use --keys FILE"
            )

    def _parse(self, word: str) -> list[Step]:
        if pause := _WAIT.fullmatch(word):
            return [Step(pause=float(pause[1]))]
        if _NUMBERED.fullmatch(word):
            return [Step(word)]
        if keys := _WORD.fullmatch(word):
            steps = [Step(key, at_once=key != "a" or bool(keys[1])) for key in keys[2]]
            return steps * int(keys[3] or 1)
        raise ScriptError(
            f"{self.name}: {word!r} is no word of a key script; see mukca record --help-all"
        )

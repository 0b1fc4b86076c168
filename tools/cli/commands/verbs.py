"""The verbs: mukca's own, as ``verbs.txt`` has them, and those of installed packages.

A verb is a function ``run(options, terminal)`` that returns the exit status. The annotation of
``options`` is a dataclass of options, see :mod:`..arguments`.
"""

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from ....drivers import Entry, PluginError, installed, load
from .. import Terminal

GROUPS = {
    "every day": "record check solve validate report",
    "before": "demo print-parts plan robots drivers",
    "afterwards": "command poses export tool handeye rezero compare",
    "many arms": "fleet",
    "data": "info convert extract stream",
    "for developers": "simulate emulate",
}
"""mukca's own verbs by what people do."""
PLUGINS = "of other packages"
"""Heading of the others."""
_PAGES = Path(__file__).with_name("verbs.txt").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Verb(Entry):
    """A verb, before its module is imported."""

    text: str = ""
    """Text below the options; of a package's verb it is the rest of its docstring."""
    often: tuple[str, ...] = ()
    """Options that ``--help`` shows; none for all."""

    @property
    def run(self) -> Callable[[Any, Terminal], int]:
        """The function, with its module imported; a :class:`.PluginError` where that fails.

        A verb of mukca's own that cannot be imported is a defect, or was interrupted.
        """
        if self.source == "mukca":
            module, _, name = self.target.partition(":")
            return getattr(import_module(module), name)
        function = load(self, "verb")
        if not callable(function) or "options" not in _annotations(function):
            raise PluginError(
                f"verb {self.name!r} of {self.source}: {self.target} is no function of options "
                "and terminal"
            )
        return cast("Callable[[Any, Terminal], int]", function)

    @property
    def options(self) -> Any:
        """The dataclass of its options."""
        return _annotations(self.run)["options"]

    @property
    def help(self) -> str:
        """The text, with ``LIST`` of the module in place of ``{list}``."""
        if not self.text:
            return (inspect.getdoc(self.run) or "").partition("\n\n")[2]
        module = import_module(self.target.partition(":")[0])
        return self.text.replace("{list}", getattr(module, "LIST", ""))


def _annotations(function: Any) -> dict[str, Any]:
    return inspect.get_annotations(function, eval_str=True)


def _own(name: str, module: str, line: str, often: str, text: str) -> Verb:
    function = f"run_{name.replace('-', '_')}"
    target = f"{__package__}.{module or name.replace('-', '_')}:{function}"
    return Verb(name, target, line, text=text, often=tuple(often.split()))


VERBS: dict[str, Verb] = {
    words[0]: _own(*words)
    for words in re.findall(
        r"(?ms)^# ([\w-]+)(?: in (\w+))?: (.*?)\n(?:often: (.*?)\n)?(.*?)(?=^# |\Z)",
        _PAGES,
    )
}
"""mukca's own verbs."""


@cache
def verb_table() -> dict[str, Verb]:
    """Return all verbs by name: mukca's own, then those of installed packages."""
    entries = installed("verbs")
    others = {e.name: Verb(e.name, e.target, e.line, e.source) for e in entries}
    return VERBS | others | VERBS


def verb_of(name: str) -> Verb | None:
    """Return a verb, if there is one; to look for those of other packages takes a while."""
    return VERBS.get(name) or verb_table().get(name)


def by_group() -> str:
    """Return all verbs, a line each, below what people do."""
    table = verb_table()
    groups = {group: names.split() for group, names in GROUPS.items()}
    groups[PLUGINS] = [name for name in table if name not in VERBS]
    lines: list[str] = []
    for group, names in groups.items():
        if names:
            lines += [f"{group}:", *(f"  {v:12} {table[v].line}" for v in names), ""]
    return "\n".join([*lines, "mukca VERB --help shows a verb's options and examples."])

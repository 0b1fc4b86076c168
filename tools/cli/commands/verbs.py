"""The verbs and their parsers: mukca's own, as ``verbs.txt`` has them, and those of packages.

A verb is a function ``run(options, terminal)`` that returns the exit status. The annotation of
``options`` is a dataclass of options, see :mod:`..arguments`.
"""

import argparse
import difflib
import inspect
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn, cast

from ...._version import __version__
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


OPTION = re.compile(r"--?[A-Za-z]")
"""Begin of a word that is an option, not a negative number."""
PLAIN = {
    r"^argument (\S+): invalid \w+ value: ('-?\d+),(\d+\w*')": r"\1 \2,\3: not a number; "
    r"did you mean \2.\3?",
    r"^argument (\S+): invalid (?:milli)?metres value: (.*)": r"\1 \2: no length; type it with its "
    "unit, as in 50.1mm",
    r"^argument (\S+): invalid int value: (.*)": r"\1 \2: not a whole number",
    r"^argument (\S+): invalid \w+ value: (.*)": r"\1 \2: not a number",
    r"^argument (\S+): invalid choice: (\S+) \(choose from (.*)\)": r"\1 \2: choose among \3; "
    "HELP says what each is",
    r"^argument (\S+): expected one argument": r"\1: no value; \1=-1 gives one with a minus sign",
    r"^argument (\S+): ignored explicit argument (.*)": r"\1 \2: takes no value",
    r"^unrecognized arguments: ": "more words than there are arguments: ",
    r"^argument (\S+): ": r"\1: ",
    r"^the following arguments are required: (.*)": r"missing: \1; HELP shows examples",
}
"""Messages of ``argparse`` and their plain words."""
QUIET = "say nothing but warnings, errors, and what --json asks for"
VERBOSE = "say each step of long work, and --details where there are"
EXAMPLES = 2
"""Examples that ``--help`` shows."""


class Parser(argparse.ArgumentParser):
    """Parser whose errors are one line, and say what an unknown option is probably meant for."""

    typed: Sequence[str] = ()
    """Words of the command line."""
    names: Collection[str] = ("-h", "--help", "--version")
    """Options that there are."""
    lists_them = "mukca --help"
    """Command that lists these."""

    def error(self, message: str) -> NoReturn:
        """Raise a :class:`UsageError` on the first unknown option; without any, on the message."""
        from ....solver.calibration import UsageError

        options = [word.partition("=")[0] for word in self.typed if OPTION.match(word)]
        for option in options:
            if not any(name.startswith(option) for name in self.names):
                advice = f"; {self.lists_them} lists them{meant(option, self.names)}"
                raise UsageError(f"no option is called {option}{advice}")
        for pattern, words in PLAIN.items():
            message = re.sub(pattern, words, message)
        raise UsageError(message.replace("HELP", self.lists_them))


def meant(word: str, names: Collection[str]) -> str:
    """Return which name a word is probably meant for; empty where none is near."""
    name_by_letters = {name.lstrip("-"): name for name in names}
    matches = difflib.get_close_matches(word.lstrip("-"), name_by_letters, 1)
    return f"; did you mean {name_by_letters[matches[0]]}?" if matches else ""


def build_parser(verb: str | None, words: Sequence[str] = ()) -> Parser:
    """Return the parser; only the given verb's own options are filled in."""
    parser = Parser(
        prog="mukca",
        usage="mukca VERB [options]",
        description="Calibrate a robot arm with a printed ball and socket base.",
        epilog=None if verb in VERBS else by_group(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.typed = words
    parser.add_argument(
        "--version",
        action="version",
        version=f"mukca {__version__}",
        help="show the version and exit",
    )
    parsers = parser.add_subparsers(
        dest="verb", metavar="VERB", required=True, help=argparse.SUPPRESS, prog="mukca"
    )
    table = VERBS if verb in VERBS else verb_table()
    for name, about in table.items():
        sub = parsers.add_parser(
            name,
            description=f"{about.line[0].upper()}{about.line[1:]}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        sub.typed = words
        if name == verb:
            parser.names = sub.names = _fill(
                sub, about, everything="--help-all" in words
            )
            parser.lists_them = sub.lists_them = f"mukca {name} --help-all"
    return parser


def _fill(
    parser: argparse.ArgumentParser, about: Verb, *, everything: bool
) -> list[str]:
    """Add a verb's options, ``everything`` or those used often in its help; return their names."""
    from .. import add_options, option_names

    options, text = about.options, about.help
    often = None if everything else about.often or None
    names = option_names(options)
    add_options(parser, options, often)
    hidden = len(names) - len(often or names)
    more = "all about it"
    if hidden:
        more = f"{hidden} more option{'s' * (hidden > 1)}, and all about them"
    parser.add_argument("--help-all", action="help", help=more)
    parser.add_argument("-q", "--quiet", action="store_true", help=QUIET)
    parser.add_argument("-v", "--verbose", action="store_true", help=VERBOSE)
    parser.epilog = text if everything else _in_short(text)
    return [*names, "-h", "--help", "--help-all", "-q", "--quiet", "-v", "--verbose"]


def _in_short(text: str) -> str:
    """Return the lists of a verb's text, such as formats, and its first examples."""
    lists = [part for part in text.strip().split("\n\n") if re.match(r"\w+:\n", part)]
    for number, part in enumerate(lists):
        if part.startswith("example"):
            head, *examples = re.split(r"(?m)^(?=  mukca )", part)
            lists[number] = "".join([head, *examples[:EXAMPLES]]).rstrip()
    return "\n\n".join(lists)

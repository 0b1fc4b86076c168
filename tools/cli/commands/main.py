"""The command line: from arguments to a verb, and from errors to exit statuses.

0 done; 1 the result fails its limits; 2 bad usage or bad input; 3 the data do not suffice;
70 a defect of mukca itself, which :func:`report_defect` tells; 130 interrupted.
"""

import argparse
import difflib
import errno
import gc
import os
import re
import sys
from collections.abc import Collection, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from ...._version import __version__
from ....drivers import PluginError
from ....errors import MukcaError
from .. import Terminal, write_error
from .verbs import VERBS, Verb, by_group, verb_of, verb_table

UNWRITABLE = (errno.ENOSPC, errno.EIO, errno.EBADF, errno.EDQUOT)
"""Errors of a standard output that is full, or gone."""
UNREACHABLE = (errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP)
"""Errors of a path that was typed, where no verb tells them."""
GARBAGE = 20_000
"""New objects after which Python looks for garbage; its own 700 cost a twentieth of a solve."""
EXAMPLES = 2
"""Examples that ``--help`` shows."""


TYPED = {
    "by force=True": "by --force",
    "ball without flange": "--ball without --flange",
}
"""Words of the library's errors for its arguments, and those of the command line."""


OPTION = re.compile(r"--?[A-Za-z]")
"""Begin of a word that is an option, not a negative number."""
PLAIN = {
    r"^argument (\S+): invalid int value: (.*)": r"\1 \2: not a whole number",
    r"^argument (\S+): invalid \w+ value: (.*)": r"\1 \2: not a number",
    r"^argument (\S+): invalid choice: (\S+) \(choose from (.*)\)": r"\1 \2: choose among \3",
    r"^argument (\S+): expected one argument": r"\1: no value; \1=-1 gives one with a minus sign",
    r"^argument (\S+): ignored explicit argument (.*)": r"\1 \2: takes no value",
    r"^unrecognized arguments: ": "more words than there are arguments: ",
    r"^argument (\S+): ": r"\1: ",
    r"^the following arguments are required: (.*)": r"missing: \1; HELP shows examples",
}
"""Messages of ``argparse`` and their plain words."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status; an exception is a defect of mukca."""
    # The matrices here are small: threads of the linear algebra cost more than they bring.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(GARBAGE)
    if "_ARGCOMPLETE" in os.environ and find_spec("argcomplete"):
        complete(os.environ.get("COMP_LINE", ""))
    if sys.stdout is None:  # pyright: ignore[reportUnnecessaryComparison]  (closed by the caller)
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115
    reconfigure = getattr(sys.stdout, "reconfigure", None)
    if reconfigure is not None:
        errors = sys.stdout.errors
        # No name stops a command, and whoever waits for a line gets it, through a pipe, too.
        reconfigure(
            errors="replace" if errors == "strict" else errors, line_buffering=True
        )
    words = list(sys.argv[1:] if argv is None else argv)
    verb = words[0] if words else None
    try:
        parser = build_parser(verb, words)
        if verb is None:
            parser.print_help()
            return 0
        if verb_of(verb) is None and not verb.startswith("-"):
            advice = f"mukca --help lists them{meant(verb, verb_table())}"
            write_error(f"mukca: no verb is called {verb!r}; {advice}")
            return 2
        arguments = parser.parse_args(words)
        terminal = Terminal(json=bool(getattr(arguments, "json", False)))
        status = run_verb(arguments, terminal)
        sys.stdout.flush()
        return status
    except MukcaError as error:
        line = " ".join(str(error).split())
        for argument, word in TYPED.items():
            line = line.replace(argument, word)
        name = f"mukca {verb}" if verb and verb_of(verb) else "mukca"
        write_error(f"{name}: {line}")
        return 1 if error.failed else 2
    except KeyboardInterrupt:
        write_error(f"mukca {verb}: interrupted")
        return 130
    except BrokenPipeError:  # the reader went away, as with `| head`
        _write_nowhere()
        return 141
    except OSError as error:
        if error.filename is not None and error.errno in UNREACHABLE:
            write_error(f"mukca {verb}: {error.filename}: {error.strerror}")
            return 2
        if error.filename is not None or error.errno not in UNWRITABLE:
            raise
        _write_nowhere()
        write_error(f"mukca {verb}: what it says cannot be written: {error.strerror}")
        return 1


def _write_nowhere() -> None:
    """Let standard output lead nowhere, so that nothing fails at the end of the program."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complete(line: str) -> None:
    """Tell a shell what may follow a line, and end; needs mukca[completion], which is small.

    A shell asks so after ``eval "$(register-python-argcomplete mukca)"``.
    """
    import argcomplete

    verb = next(iter(line.split()[1:]), None)
    try:
        parser = build_parser(verb if verb and verb_of(verb) else None, ["--help-all"])
    except PluginError:  # its options are not known, all else is
        parser = build_parser(None)
    argcomplete.autocomplete(parser)


def run_verb(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run the verb that was typed, and return its exit status; a MukcaError is bad input."""
    from .. import read_options

    about = verb_of(arguments.verb)
    assert about is not None  # it was parsed
    return about.run(read_options(arguments), terminal)


class _Parser(argparse.ArgumentParser):
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


def build_parser(
    verb: str | None, words: Sequence[str] = ()
) -> argparse.ArgumentParser:
    """Return the parser; only the given verb's own options are filled in."""
    parser = _Parser(
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
    often = None if everything or not about.often else about.often
    names = option_names(options)
    hidden = len(names) - len(about.often) if often else 0
    add_options(parser, options, often)
    more = "all about it"
    if hidden:
        more = f"{hidden} more option{'s' * (hidden > 1)}, and all about them"
    parser.add_argument("--help-all", action="help", help=more)
    parser.epilog = text if everything else _in_short(text)
    return [*names, "-h", "--help", "--help-all"]


def _in_short(text: str) -> str:
    """Return the lists of a verb's text, such as formats, and its first examples."""
    lists = [part for part in text.strip().split("\n\n") if re.match(r"\w+:\n", part)]
    for number, part in enumerate(lists):
        if part.startswith("example"):
            head, *examples = re.split(r"(?m)^(?=  mukca )", part)
            lists[number] = "".join([head, *examples[:EXAMPLES]]).rstrip()
    return "\n\n".join(lists)

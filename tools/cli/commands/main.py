"""The command line: from arguments to a verb, and from errors to exit statuses.

0 done; 1 the result fails its limits; 2 bad usage or bad input; 3 the data do not suffice;
70 a defect of mukca itself, which :func:`report_defect` tells; 130 interrupted.
"""

import argparse
import errno
import gc
import os
import platform
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from ...._version import __version__
from ....drivers import PluginError
from ....errors import MukcaError
from .. import Terminal, lab_words, write_error
from .verbs import Parser, build_parser, meant, verb_of, verb_table

UNWRITABLE = (errno.ENOSPC, errno.EIO, errno.EBADF, errno.EDQUOT)
"""Errors of a standard output that is full, or gone."""
UNREACHABLE = (errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP)
"""Errors of a path that was typed, where no verb tells them."""
GARBAGE = 20_000
"""New objects after which Python looks for garbage; its own 700 cost a twentieth of a solve."""

DEFECT = 70
"""Exit status, as EX_SOFTWARE of sysexits.h."""
SHOW = "MUKCA_TRACEBACK"
"""Environment variable by which the traceback is shown instead, for those who mend it."""


TYPED = {
    "by force=True": "by --force",
    "ball without flange": "--ball without --flange",
}
"""Words of the library's errors for its arguments, and those of the command line."""

LIVE = ("record", "stream", "emulate")
"""Verbs that wait for an arm or a program, and write of their own accord."""


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
    if reconfigure:
        errors = sys.stdout.errors
        # No name stops a command, and whoever waits for a line gets it, through a pipe, too.
        reconfigure(
            errors="replace" if errors == "strict" else errors, line_buffering=True
        )
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
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
        words += _of_lab(parser, words)
        arguments = parser.parse_args(words)
        quiet, verbose = arguments.quiet, arguments.verbose
        json = getattr(arguments, "json", False)
        arguments.details = getattr(arguments, "details", False) or verbose
        terminal = Terminal(json=json, quiet=quiet, verbose=verbose)
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


def _of_lab(parser: Parser, words: Sequence[str]) -> list[str]:
    """Return the options that a lab typed once, after they were told."""
    if not {"-h", "--help", "--help-all"}.isdisjoint(words):
        return []
    file, options = lab_words(words, parser.names)
    if options:
        write_error(f"{file}: {shlex.join(options)}")
    return options


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
    assert about  # it was parsed
    options = read_options(arguments)
    if about.name in LIVE:
        return about.run(options, terminal)
    with terminal.at_work(f"mukca {about.name}"):
        return about.run(options, terminal)


def report_defect(error: Exception, words: Sequence[str]) -> int:
    """Write a report of an unexpected exception, say where it lies, and return the exit status.

    The report has version, command and traceback. Samples are not in it, only what the message of
    the exception itself quotes.
    """
    if SHOW in os.environ:
        raise error
    verb = " ".join(["mukca", *words[:1]])
    folder = "(gone)"
    with suppress(OSError):
        folder = str(Path.cwd())
    lines = [
        f"mukca {__version__}, Python {platform.python_version()}, {platform.platform()}",
        f"command: {shlex.join(['mukca', *words])}",
        f"folder: {folder}",
        "",
        "".join(traceback.format_exception(error)),
    ]
    try:
        number, file = tempfile.mkstemp(prefix="mukca-defect-", suffix=".txt")
        os.close(number)
        Path(file).write_text(
            "\n".join(lines), encoding="utf-8", errors="backslashreplace"
        )
        advice = f"please send us {file}, which holds the command and the traceback, no samples"
    except OSError as reason:
        advice = f"no report could be written ({reason.strerror}); {SHOW}=1 shows the traceback"
    place = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}"
    write_error(
        f"{verb}: stopped by a defect of mukca ({where}), ours to mend: {advice}"
    )
    return DEFECT

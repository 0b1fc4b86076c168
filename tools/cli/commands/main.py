"""The command line: from arguments to a verb, and from errors to exit statuses.

0 done; 1 the result fails its limits; 2 bad usage or bad input; 3 the data do not suffice;
70 a defect of mukca itself, which :func:`report_defect` tells; 130 interrupted.
"""

import argparse
import importlib
import os
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...._version import __version__
from ....errors import MukcaError
from .. import Terminal

_PAGES = Path(__file__).with_name("verbs.txt").read_text(encoding="utf-8")
VERBS: dict[str, tuple[str, str, str]] = {
    name: (line, text, module or name.replace("-", "_"))
    for name, module, line, text in re.findall(
        r"(?ms)^# ([\w-]+)(?: in (\w+))?: (.*?)\n(.*?)(?=^# |\Z)", _PAGES
    )
}
"""Line of each verb in ``mukca --help``, the text below its options, and its module."""


TYPED = {
    "by force=True": "by --force",
    "flange and ball go together": "--flange LINK and --ball X Y Z go together",
}
"""Words of the library's errors for its arguments, and those of the command line."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status; an exception is a defect of mukca."""
    # The matrices here are small: threads of the linear algebra cost more than they bring.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    words = list(sys.argv[1:] if argv is None else argv)
    verb = words[0] if words else None
    try:
        arguments = build_parser(verb).parse_args(words)
        terminal = Terminal(json=bool(getattr(arguments, "json", False)))
        return run_verb(arguments, terminal)
    except MukcaError as error:
        line = " ".join(str(error).split())
        for argument, typed in TYPED.items():
            line = line.replace(argument, typed)
        sys.stderr.write(f"mukca {verb}: {line}\n")
        return 1 if error.failed else 2
    except KeyboardInterrupt:
        sys.stderr.write(f"mukca {verb}: interrupted\n")
        return 130
    except BrokenPipeError:  # the reader went away, as with `| head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141


def run_verb(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run the verb that was typed, and return its exit status; a MukcaError is bad input."""
    from .. import read_options

    return _verb(arguments.verb)[0](read_options(arguments), terminal)


def build_parser(verb: str | None) -> argparse.ArgumentParser:
    """Return the parser; only the given verb's own options are filled in."""
    parser = argparse.ArgumentParser(
        prog="mukca",
        description="Calibrate a robot arm with a printed ball and socket base.",
        epilog="mukca VERB --help shows a verb's options and an example.",
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"mukca {__version__}",
        help="show the version and exit",
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, (line, text, _) in VERBS.items():
        sub = verbs.add_parser(
            name,
            help=line,
            description=line[0].upper() + line[1:] + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name == verb:
            from .. import add_options

            run, module = _verb(name)
            sub.epilog = text if "{list}" not in text else text.replace("{list}", module.LIST)
            add_options(sub, run.__annotations__["options"])
    return parser


def _verb(name: str) -> tuple[Callable[[Any, Terminal], int], Any]:
    """Return the function ``run_VERB``, whose first annotation is its options, and its module.

    Where the verb's text has ``{list}``, the module has ``LIST``.
    """
    module = importlib.import_module(f".{VERBS[name][2]}", __package__)
    return getattr(module, f"run_{name.replace('-', '_')}"), module

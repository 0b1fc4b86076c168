"""The options of ``mukca solve``: what there is, for which method, and what goes together."""

import argparse
from pathlib import Path
from typing import Any

from .arguments import UsageError, add_load, add_robot

__all__ = ["COMMON", "ONLY_AUTO", "ONLY_PAPER", "add_options", "settle"]

COMMON = (
    "base",
    "tip",
    "flange",
    "ball",
    "distance",
    "free",
    "fix",
    "split_moved",
    "accept_distorted",
)
"""Options of both methods that change the result."""
ONLY_PAPER = {"optimizer": "gauss-newton", "regularization": 1e-4, "max_iterations": 200}
"""Options of ``--method paper``, and their defaults."""
ONLY_AUTO: dict[str, Any] = {
    "known": [],
    "distance_deviation": 3e-5,
    "without": [],
    "payload": None,
    "gravity": None,
}
"""Options of ``--method auto``, and their defaults."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add all options and arguments."""
    parser.add_argument("train", nargs="+", type=Path, metavar="TRAIN", help="placements to fit")
    parser.add_argument(
        "--test", nargs="+", type=Path, default=[], metavar="HELD_OUT", help="placements held out"
    )
    parser.add_argument(
        "--method",
        choices=("auto", "paper"),
        default="auto",
        help="auto: geometry, joint compliance and transmission error, as far as the data support "
        "them; paper: Eq. (5), geometry alone (default: %(default)s)",
    )
    add_robot(parser)
    fit = parser.add_argument_group("fit")
    fit.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres (default: the recording's, or 0.05)",
    )
    words = "joint names, JOINT.x .. JOINT.yaw, JOINT.xyz or JOINT.rpy; * stands for any text"
    fit.add_argument("--free", nargs="+", default=[], metavar="P", help=f"what is free: {words}")
    fit.add_argument("--fix", nargs="+", default=[], metavar="P", help="what is not, likewise")
    fit.add_argument(
        "--split-moved",
        action="store_true",
        help="where a base moved, give the part after it a socket of its own",
    )
    fit.add_argument(
        "--accept-distorted",
        action="store_true",
        help="export even a model that does not reproduce the sockets' distance",
    )
    _add_auto(parser)
    _add_paper(parser)
    output = parser.add_argument_group("output")
    output.add_argument("--out", type=Path, metavar="DIR", help="write the results to this folder")
    output.add_argument("--force", action="store_true", help="overwrite results in DIR")
    output.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def _add_auto(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("method auto")
    group.add_argument(
        "--known",
        nargs="+",
        default=[],
        metavar="A:0-B:0=M[+-S]",
        help="further measured distances between sockets, with their standard deviation, or a "
        "file with one a line",
    )
    group.add_argument(
        "--distance-deviation",
        type=float,
        metavar="M",
        help="standard deviation of --distance (default: 3e-5, a caliper)",
    )
    group.add_argument(
        "--without",
        nargs="+",
        choices=("compliance", "transmission", "joint-noise"),
        help="what is not to be tried",
    )
    add_load(parser)


def _add_paper(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("method paper")
    group.add_argument(
        "--optimizer",
        choices=("gauss-newton", "ipopt"),
        help="both reach the same minimum; ipopt is the paper's (default: gauss-newton)",
    )
    group.add_argument("--regularization", type=float, metavar="L", help="lambda (default: 1e-4)")
    group.add_argument("--max-iterations", type=int, metavar="N", help="(default: 200)")


def settle(arguments: argparse.Namespace) -> None:
    """Fill in defaults, and refuse options of the other method: they would do nothing.

    Raises:
        UsageError: Such an option, or a number that cannot be.
    """
    for method, options in (("paper", ONLY_PAPER), ("auto", ONLY_AUTO)):
        for name, default in options.items():
            given = getattr(arguments, name)
            if given in (None, []):
                setattr(arguments, name, default)
            elif arguments.method != method:
                raise UsageError(
                    f"--{name.replace('_', '-')} belongs to --method {method}; this is "
                    f"--method {arguments.method}"
                )
    if arguments.max_iterations < 1:
        raise UsageError(f"--max-iterations {arguments.max_iterations}: at least 1 is needed")
    if not 0 < arguments.distance_deviation < 1:
        raise UsageError(f"--distance-deviation {arguments.distance_deviation}: give metres")

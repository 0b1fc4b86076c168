"""The options of ``mukca solve``: what there is, and for which method."""

import argparse
from pathlib import Path

from .robot_arguments import add_load, add_measured, add_repeatability, add_robot, add_type_prior


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
        help="auto: geometry, elasticity and transmission error, as far as the data support "
        "them; paper: Eq. (5), geometry alone (default: %(default)s)",
    )
    add_robot(parser, several=True)
    fit = parser.add_argument_group("fit")
    fit.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres (default: the recording's, or 0.05); "
        "1 mm wrong makes the arm 2 %% too long",
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
    add_repeatability(parser)
    output = parser.add_argument_group("output")
    output.add_argument("--out", type=Path, metavar="DIR", help="write the results to this folder")
    output.add_argument("--force", action="store_true", help="overwrite results in DIR")
    output.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def _add_auto(parser: argparse.ArgumentParser) -> None:
    add_measured(parser)
    group = parser.add_argument_group("method auto")
    group.add_argument(
        "--sockets-at",
        nargs="+",
        default=[],
        metavar="FILE",
        help="measured coordinates of sockets, a CSV file with the columns frame, socket, x [mm], "
        "y [mm], z [mm], deviation [mm]; the frame `base` is the robot's own",
    )
    group.add_argument(
        "--without",
        nargs="+",
        default=[],
        choices=("compliance", "tilt", "play", "transmission", "joint-noise"),
        help="what is not to be tried",
    )
    add_type_prior(group)
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

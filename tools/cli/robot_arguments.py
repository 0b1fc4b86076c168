"""Arguments that several verbs share: the robot, and the placements."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...solver.calibration import UsageError

if TYPE_CHECKING:
    from ...recorder.dataset import Placement
    from ...solver.calibration import Method, SolveOptions
    from ...solver.data import Load, Measurement
    from ...solver.robot import Robot

__all__ = [
    "UsageError",
    "add_load",
    "add_measured",
    "add_repeatability",
    "add_robot",
    "known_of",
    "load_of",
    "measure_all",
    "placements_of",
    "robot_of",
    "settings_of",
    "split_test",
]


def add_robot(parser: argparse.ArgumentParser, *, several: bool = False) -> None:
    """Add ``--robot`` and what says where its chain begins and ends.

    Args:
        parser: Where to.
        several: Whether there may be several robots, each with a name; then
            :func:`.several.robots_of` reads the arguments.
    """
    group = parser.add_argument_group("robot")
    more = "; several as NAME=R, each by an option of its own" if several else ""
    each = "; of several robots NAME=LINK" if several else ""
    action = "append" if several else "store"
    group.add_argument(
        "--robot",
        required=True,
        action=action,
        metavar="R",
        help=f"a shipped robot's name, or a URDF file{more}",
    )
    group.add_argument(
        "--base", action=action, metavar="LINK", help=f"the base link (default: the root{each})"
    )
    group.add_argument(
        "--tip",
        action=action,
        metavar="LINK",
        default=None if several else "ball_link",
        help=f"the ball's link (default: ball_link{each})",
    )
    group.add_argument(
        "--flange",
        action=action,
        metavar="LINK",
        help=f"for a URDF without a ball: the link that carries it{each}",
    )
    group.add_argument(
        "--ball",
        metavar=("X", "Y", "Z"),
        nargs=3,
        type=float,
        help="with --flange: the ball's centre in that link's frame, in metres",
    )


def robot_of(arguments: argparse.Namespace) -> "Robot":
    """Return the chain that the arguments of :func:`add_robot` name.

    Raises:
        ModelError: No such robot, link, or chain, or one of --flange and --ball without the
            other.
    """
    from ...solver.robot import load_robot

    return load_robot(
        arguments.robot,
        base=arguments.base,
        tip=arguments.tip,
        flange=arguments.flange,
        ball=arguments.ball,
    )


def add_measured(parser: argparse.ArgumentParser) -> None:
    """Add ``--known`` and ``--distance-deviation``, what was measured, and ``--zeros``."""
    group = parser.add_argument_group("distances and zeros, for method auto")
    group.add_argument(
        "--known",
        nargs="+",
        default=[],
        metavar="A:0-B:0=M[+-S]",
        help="further measured distances between sockets, to which the fit keeps as closely as "
        "their standard deviation S says; or a file with one a line",
    )
    group.add_argument(
        "--distance-deviation",
        type=float,
        metavar="M",
        help="standard deviation of --distance (default: 3e-5, a caliper)",
    )
    group.add_argument(
        "--zeros",
        action="store_const",
        const=True,
        help="the joints' zeros may be off by degrees: for arms made of servos",
    )


def add_type_prior(group: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:  # pyright: ignore[reportPrivateUsage]
    """Add ``--type-prior``, what other arms of the type tell."""
    group.add_argument(
        "--type-prior",
        nargs="+",
        default=[],
        metavar="FILE",
        help="method auto: calibration.json of other arms of the type, or a fleet's "
        "elasticity.json: how far their joints give way is much the same in this one; the data "
        "decide how far to believe it (default: shipped, what was measured of other arms, so far "
        "of Pandas; none: nothing)",
    )


def known_of(words: Sequence[str]) -> list[str]:
    """Return known distances, one a word; a word that is a file stands for its lines."""
    distances: list[str] = []
    for word in words:
        file = Path(word)
        if file.is_file():
            lines = (line.split("#")[0] for line in file.read_text(encoding="utf-8").splitlines())
            distances += [line for line in lines if line.strip()]
        else:
            distances.append(word)
    return distances


def settings_of(arguments: argparse.Namespace, method: "Method" = "auto") -> "SolveOptions":
    """Return the settings that the functions of this module ask for.

    Raises:
        UsageError: A value that cannot be, or one of the other method.
    """
    from ...solver.calibration import SolveOptions

    return SolveOptions(
        method=method,
        known=known_of(arguments.known),
        distance_deviation=arguments.distance_deviation,
        zeros=arguments.zeros,
        type_prior=getattr(arguments, "type_prior", ()),
        payload=arguments.payload,
        gravity=arguments.gravity,
    ).validated()


def add_load(parser: argparse.ArgumentParser, purpose: str = "joint compliance") -> None:
    """Add what pulls at the joints."""
    group = parser.add_argument_group(f"load, for {purpose}")
    group.add_argument(
        "--payload", type=float, metavar="KG", help="mass at the ball beyond the model's"
    )
    group.add_argument(
        "--gravity",
        nargs=3,
        type=float,
        metavar=("X", "Y", "Z"),
        help="acceleration in the base frame in m/s^2, for an arm on a wall or ceiling",
    )


def load_of(arguments: argparse.Namespace) -> "Load":
    """Return the load that the arguments of :func:`add_load` name.

    Raises:
        UsageError: A negative payload, or a gravity that is not about 9.8 m/s^2.
    """
    from ...solver.calibration import SolveOptions

    return SolveOptions(payload=arguments.payload, gravity=arguments.gravity).validated().load


def placements_of(paths: Sequence[Path]) -> "list[Placement]":
    """Read all placements that paths stand for."""
    from ...recorder import find_placements, read_placement

    return [read_placement(path) for path in find_placements(paths)]


def measure_all(
    paths: Sequence[Path], robot: "Robot", distance: float | None, *, sockets: int = 2
) -> "list[Measurement]":
    """Read and check all placements that paths stand for.

    Raises:
        MukcaError: A placement that cannot be read or used; the message names it.
    """
    from ...solver.data import measure

    return [measure(p, robot, distance, sockets=sockets) for p in placements_of(paths)]


def split_test(train: Sequence[Path], test: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """Return the held-out placements, without those that a test folder shares with training.

    Args:
        train: Paths of placements, or folders of them.
        test: Likewise.

    Returns:
        The placements to test on, and a line for each that was left out.

    Raises:
        UsageError: A training placement is named for the test too.
    """
    from ...recorder import find_placements

    trained = {path.resolve() for path in find_placements(train)}
    kept: list[Path] = []
    left_out: list[str] = []
    for path in test:
        inside = find_placements([path])
        for placement in inside:
            if placement.resolve() not in trained:
                kept.append(placement)
            elif placement == path:
                raise UsageError(f"{path}: trained on, so it cannot be held out as well")
            else:
                left_out.append(f"{placement}: trained on, so left out of the test")
    return kept, left_out


def add_repeatability(parser: argparse.ArgumentParser) -> None:
    """Add the option that says how well the arm repeats, on which the verdict's limits rest."""
    parser.add_argument(
        "--repeatability-mm",
        type=float,
        metavar="MM",
        help="the arm's repeatability, from its data sheet (default: what is known of the arm)",
    )

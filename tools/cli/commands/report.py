"""``mukca report``: the report of a calibration, as one HTML file and as JSON."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.results import OutputError, write_files
from .. import Terminal
from ..robot_arguments import UsageError

if TYPE_CHECKING:
    from ...report.build import Options

EXAMPLE = """example:
  mukca report calibrated/calibration.json --open
  mukca report calibrated/calibration.json --known left:0-right:0=0.350+-0.0001 --force

The page needs no other file and no network. Exit status 1: some limit is not kept."""

_LIMITS = {
    "--repeatability-mm": "the arm's repeatability, from its data sheet",
    "--limit-mae-mm": "mean absolute error at held-out placements",
    "--limit-distance-mm": "error of the sockets' distance there, mean of absolute values",
    "--limit-between-mm": "error of distances between placements, likewise",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("calibration", type=Path, metavar="CALIBRATION", help="calibration.json")
    limits = parser.add_argument_group("limits (default: by the arm's repeatability)")
    for option, words in _LIMITS.items():
        limits.add_argument(option, type=float, metavar="MM", help=words)
    limits.add_argument(
        "--known",
        nargs="+",
        default=[],
        metavar="K",
        help="distances between sockets of different placements, measured from outside, in "
        "metres: A:0-B:0=0.175 or A:0-B:0=0.175+-0.0001, or a file with one a line",
    )
    parser.add_argument(
        "--tolerance-mm",
        type=float,
        default=0.5,
        metavar="MM",
        help="the error that your task allows (default: %(default)s)",
    )
    output = parser.add_argument_group("output")
    output.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="where to (default: beside CALIBRATION)",
    )
    output.add_argument("--force", action="store_true", help="overwrite another report in DIR")
    output.add_argument("--open", action="store_true", help="show it in the web browser")
    output.add_argument("--json", action="store_true", help="print report.json, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Write the report, and show it in short."""
    from ....solver.results import read_calibration
    from ...report import build_report, show

    document = read_calibration(arguments.calibration)
    source = str(arguments.calibration)
    report = build_report(document, source, _options(arguments))
    folder = arguments.calibration.parent if arguments.out is None else arguments.out
    new = write_report(folder, report.files, force=arguments.force)
    show(terminal.console, report.figures)
    page = folder / "report.html"
    words = "and report.json beside it, the same figures for scripts"
    terminal.say(f"Wrote {page}, {words}" if new else f"{page} is up to date, {words}")
    if arguments.open:
        open_page(page, terminal)
    if arguments.json:
        terminal.emit(report.figures)
    return 1 if report.figures.verdict.status == "fail" else 0


def _options(arguments: argparse.Namespace) -> "Options":
    from ....solver.data import parse_known
    from ...report.build import Options
    from .. import known_of

    return Options(
        repeatability=metres("--repeatability-mm", arguments.repeatability_mm),
        mean_absolute_error=metres("--limit-mae-mm", arguments.limit_mae_mm),
        distance_error=metres("--limit-distance-mm", arguments.limit_distance_mm),
        between_placements=metres("--limit-between-mm", arguments.limit_between_mm),
        known=[parse_known(words) for words in known_of(arguments.known)],
        tolerance=metres("--tolerance-mm", arguments.tolerance_mm) or 0.0,
    )


def metres(option: str, millimetres: float | None) -> float | None:
    """Return the length that an option in millimetres gives, if it is given [m]."""
    if millimetres is None:
        return None
    if not 0 < millimetres < 1e4:
        raise UsageError(f"{option} {millimetres}: a positive number of millimetres is needed")
    return millimetres / 1e3


def write_report(folder: Path, contents: Mapping[str, bytes], *, force: bool) -> bool:
    """Write a report's files, unless they are there already, byte for byte.

    Returns:
        Whether anything was written.

    Raises:
        OutputError: Another report is there and ``force`` is not given, or it cannot be written.
    """
    new = {name: data for name, data in contents.items() if not _holds(folder / name, data)}
    present = [folder / name for name in new if (folder / name).exists()]
    if present and not force:
        raise OutputError(
            f"{present[0]}: exists and is another report; add --force to overwrite it, or choose "
            "another folder by --out"
        )
    if new:
        write_files(folder, new)
    return bool(new)


def _holds(file: Path, data: bytes) -> bool:
    try:
        return file.read_bytes() == data
    except OSError:
        return False


def open_page(page: Path, terminal: Terminal) -> None:
    """Show a page in the web browser; where there is no screen, as over SSH, only say so."""
    import os
    import sys
    import webbrowser

    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    screen = sys.platform != "linux" or any(os.environ.get(name) for name in screens)
    if not (screen and webbrowser.open(page.resolve().as_uri())):
        terminal.say(f"No browser here; copy {page.resolve()} to a computer that has one.")

"""``mukca report``: the report of a calibration, as one HTML file and as JSON."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import UsageError
from ..files import OutputError, write_files
from ..terminal import Terminal

if TYPE_CHECKING:
    from ..report.figures import Options

EXAMPLE = """example:
  mukca report calibrated/calibration.json --open
  mukca report calibrated/calibration.json --known left:0-right:0=0.350+-0.0001 --force

The page needs no other file and no network. Exit status 1: some limit is not kept."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("calibration", type=Path, metavar="CALIBRATION", help="calibration.json")
    limits = parser.add_argument_group("limits (default: by the arm's repeatability)")
    for name, words in (
        ("repeatability", "the arm's repeatability, from its data sheet"),
        ("limit-mae", "mean absolute error at held-out placements"),
        ("limit-distance", "error of the sockets' distance there, mean of absolute values"),
        ("limit-between", "error of distances between placements, likewise"),
    ):
        limits.add_argument(f"--{name}-mm", type=float, metavar="MM", help=words)
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
    from ...solver.calibration import load_document
    from ..report.build import build_report
    from ..report.terminal import show

    document = load_document(arguments.calibration)
    source = str(arguments.calibration)
    report = build_report(document, source, _options(arguments, document, source))
    folder = arguments.calibration.parent if arguments.out is None else arguments.out
    write_report(folder, report.files, force=arguments.force)
    show(terminal.console, report.figures)
    page = folder / "report.html"
    terminal.say(f"Wrote {page}")
    if arguments.open:
        open_page(page, terminal)
    if arguments.json:
        terminal.emit(report.figures)
    return 1 if report.figures["verdict"]["status"] == "fail" else 0


def _options(arguments: argparse.Namespace, document: Mapping[str, Any], source: str) -> "Options":
    from ...solver.calibration import CalibrationError
    from ..report.between import parse_known
    from ..report.figures import Options
    from ..report.limits import limits_for

    given = {
        field: _metres(option, getattr(arguments, option))
        for field, option in (
            ("mean_absolute_error", "limit_mae_mm"),
            ("distance_error", "limit_distance_mm"),
            ("between_placements", "limit_between_mm"),
        )
    }
    repeatability = _metres("repeatability_mm", arguments.repeatability_mm)
    tolerance = _metres("tolerance_mm", arguments.tolerance_mm)
    try:
        limits = limits_for(document["model"], repeatability, given)
    except (KeyError, TypeError) as error:
        raise CalibrationError(f"{source}: damaged calibration.json: {error!r}") from None
    return Options(limits, parse_known(arguments.known), tolerance or 0.0)


def _metres(name: str, millimetres: float | None) -> float | None:
    if millimetres is None:
        return None
    if not 0 < millimetres < 1e4:
        option = name.replace("_", "-")
        raise UsageError(f"--{option} {millimetres}: a positive number of millimetres is needed")
    return millimetres / 1e3


def write_report(folder: Path, contents: Mapping[str, bytes], *, force: bool) -> None:
    """Write a report's files, unless they are there already, byte for byte.

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


def _holds(file: Path, data: bytes) -> bool:
    try:
        return file.read_bytes() == data
    except OSError:
        return False


def open_page(page: Path, terminal: Terminal) -> None:
    """Show a page in the web browser, where there is one; over SSH only say how."""
    import os
    import webbrowser

    remote = "SSH_CONNECTION" in os.environ and "DISPLAY" not in os.environ
    if remote or not webbrowser.open(page.resolve().as_uri()):
        terminal.say(f"No browser to open here; copy {page.resolve()} to a computer with one.")

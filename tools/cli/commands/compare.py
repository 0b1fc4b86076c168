"""``mukca compare``: several calibrations of one robot on the same data."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.results import refuse_existing, write_files
from .. import Terminal, measure_all
from ..robot_arguments import UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from ...report.figures import ComparisonDocument

EXAMPLE = """example:
  mukca compare paper/calibration.json auto/calibration.json
  mukca compare june/calibration.json july/calibration.json --data recordings/july --out july

Without --data, on all placements that the calibrations were trained or tested on. Differences
are judged on placements that none of them was trained on."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument(
        "calibrations", nargs="+", type=Path, metavar="CALIBRATION", help="calibration.json"
    )
    parser.add_argument(
        "--data", nargs="+", type=Path, default=[], metavar="DATA", help="placements to compare on"
    )
    parser.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in --data, in metres (default: the recording's)",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="write compare.html and .json here")
    parser.add_argument("--force", action="store_true", help="overwrite what is in DIR")
    parser.add_argument("--open", action="store_true", help="show the page in the web browser")
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Compare, show the tables, and write the page."""
    from ...report.figures import compare, contenders_of, shared_data
    from .report import open_page

    if arguments.open and arguments.out is None:
        raise UsageError("--open needs --out DIR, where the page is written")
    if arguments.out is not None:
        refuse_existing(arguments.out, force=arguments.force)
    contenders = contenders_of(arguments.calibrations)
    robot = contenders[0].calibration.robot
    if arguments.data:
        data = measure_all(arguments.data, robot, arguments.distance, sockets=1)
    else:
        data = shared_data(contenders)
    result = compare(contenders, data)
    show(terminal.console, result)
    if arguments.out is not None:
        page = write(arguments.out, result)
        terminal.say(f"Wrote {page}")
        if arguments.open:
            open_page(page, terminal)
    if arguments.json:
        terminal.emit(result)
    return 0


def show(console: "Console", result: "ComparisonDocument") -> None:
    """Print the errors of every model at every placement, and what is better."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from ....solver.assessment import short_names
    from ...report.figures import comparison_sentence

    table = Table(box=SIMPLE_HEAD, title="MAE in mm; * trained on", title_justify="left")
    table.add_column("placement", overflow="fold")
    for model in result.models:
        table.add_column(Text(model.name), justify="right")
    names = short_names([row.name for row in result.placements])
    for name, row in zip(names, result.placements, strict=True):
        cells = [
            f"{1e3 * model.mean_absolute_error:.3f}{'*' if model.trained_on else ' '}"
            for model in row.models
        ]
        table.add_row(Text(name), *cells)
    table.add_section()
    means = [
        f"{1e3 * model.summary.mean_absolute_error:.3f} " if model.summary else "- "
        for model in result.models
    ]
    table.add_row(f"= mean of {len(result.fair)} held out by all", *means, style="bold")
    console.print(table)
    for pair in result.pairs:
        console.print(Text(comparison_sentence(result, pair)))


def write(folder: Path, result: "ComparisonDocument") -> Path:
    """Write the page and its figures; return the page."""
    import msgspec

    from ....solver.results import encode
    from ...report.figures import PlotCaption
    from ...report.page import comparison_page
    from ...report.plots import comparison_plots

    plots = tuple(
        PlotCaption(id=plot.id, title=plot.title, sentence=plot.sentence)
        for plot in comparison_plots(result)
    )
    figures = msgspec.structs.replace(result, plots=plots)
    contents = {
        "compare.html": comparison_page(figures).encode("utf-8", "replace"),
        "compare.json": encode(figures) + b"\n",
    }
    return write_files(folder, contents)["compare.html"]

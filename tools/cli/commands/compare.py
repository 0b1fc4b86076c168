"""``mukca compare``: several calibrations of one robot on the same data."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.calibration import UsageError
from ....solver.results import refuse_existing, write_files
from .. import OutputOptions, Terminal, argument, measure_all, option, table

if TYPE_CHECKING:
    from rich.console import Console

    from ...report.figures import ComparisonDocument


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca compare``."""

    calibrations: Sequence[Path] = argument("calibration.json", "CALIBRATION")
    data: Sequence[Path] = option("placements to compare on", "DATA", ())
    distance: float | None = option(
        "distance of the sockets' centres in --data, in metres (default: the recording's)", "M"
    )
    out: Path | None = option("write compare.html and .json here", "DIR", group="output")
    open: bool = option("show the page in the web browser", default=False, group="output")


def run(options: Options, terminal: Terminal) -> int:
    """Compare, show the tables, and write the page."""
    from ...report.figures import compare, contenders_of, shared_data
    from .report import open_page

    if options.open and options.out is None:
        raise UsageError("--open needs --out DIR, where the page is written")
    if options.out is not None:
        refuse_existing(options.out, force=options.force)
    contenders = contenders_of(options.calibrations)
    robot = contenders[0].calibration.robot
    if options.data:
        data = measure_all(options.data, robot, options.distance, sockets=1)
    else:
        data = shared_data(contenders)
    result = compare(contenders, data)
    show(terminal.console, result)
    if options.out is not None:
        page = write(options.out, result)
        terminal.say(f"Wrote {page}")
        if options.open:
            open_page(page, terminal)
    terminal.emit(result)
    return 0


def show(console: "Console", result: "ComparisonDocument") -> None:
    """Print the errors of every model at every placement, and what is better."""
    from rich.text import Text

    from ....solver.assessment import millimetres, short_names
    from ...report.figures import comparison_sentence

    names = short_names([row.name for row in result.placements])
    rows: list[list[str]] = []
    for name, row in zip(names, result.placements, strict=True):
        errors = ((millimetres(m.mean_absolute_error), m.trained_on) for m in row.models)
        rows.append([name, *(f"{error}{'*' if trained else ' '}" for error, trained in errors)])
    means = [model.summary and model.summary.mean_absolute_error for model in result.models]
    head = f"= mean of {len(result.fair)} held out by all"
    rows.append([head, *(f"{millimetres(mean)} " for mean in means)])
    heads = ["placement", *(model.name for model in result.models)]
    bold = (len(rows) - 1,)
    console.print(table("MAE in mm; * trained on", heads, rows, bold=bold))
    for pair in result.pairs:
        console.print(Text(comparison_sentence(result, pair)))


def write(folder: Path, result: "ComparisonDocument") -> Path:
    """Write the page and its figures; return the page."""
    import msgspec

    from ....solver.results import encode
    from ...report.page import comparison_page
    from ...report.plots import comparison_plots

    plots = tuple(plot.caption for plot in comparison_plots(result))
    figures = msgspec.structs.replace(result, plots=plots)
    contents = {
        "compare.html": comparison_page(figures).encode("utf-8", "replace"),
        "compare.json": encode(figures) + b"\n",
    }
    return write_files(folder, contents)["compare.html"]

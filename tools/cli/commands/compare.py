"""``mukca compare``: several calibrations of one robot on the same data."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....solver.assessment import millimetres, short_names
from ....solver.calibration import UsageError
from ....solver.results import encode, write_files
from ...report import figures, page, plots
from .. import OutputOptions, Terminal, argument, measure_all, one_arm, option, table
from .report import open_page


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca compare``."""

    calibrations: Sequence[Path] = argument("calibration.json, or its folder", "CALIBRATION")
    data: Sequence[Path] = option("placements to compare on", "DATA", ())
    distance: float | None = option(
        "distance of the sockets' centres in --data, in metres (default: the recording's)", "M"
    )
    out: Path | None = option("write compare.html and .json here", "DIR", group="output")
    open: bool = option("show the page in the web browser", default=False, group="output")


def run(options: Options, terminal: Terminal) -> int:
    """Compare, show the tables, and write the page."""
    if options.open and options.out is None:
        raise UsageError("--open needs --out DIR, where the page is written")
    options.check_out()
    contenders = figures.contenders_of([one_arm(file) for file in options.calibrations])
    robot = contenders[0].calibration.robot
    if options.data:
        data = measure_all(options.data, robot, options.distance, sockets=1)
    else:
        data = figures.shared_data(contenders)
    result = figures.compare(contenders, data)
    show(terminal, result)
    if options.out is not None:
        written = write(options.out, result)
        terminal.say(f"Wrote {written}")
        if options.open:
            open_page(written, terminal)
    terminal.emit(result)
    return 0


def show(terminal: Terminal, result: "figures.ComparisonDocument") -> None:
    """Print the errors of every model at every placement, and what is better."""
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
    terminal.console.print(table("MAE in mm; * trained on", heads, rows, bold=bold))
    terminal.say(*(figures.comparison_sentence(result, pair) for pair in result.pairs))


def write(folder: Path, result: "figures.ComparisonDocument") -> Path:
    """Write the page and its figures; return the page."""
    import msgspec

    captions = tuple(plot.caption for plot in plots.comparison_plots(result))
    result = msgspec.structs.replace(result, plots=captions)
    contents = {
        "compare.html": page.comparison_page(result).encode("utf-8", "replace"),
        "compare.json": encode(result) + b"\n",
    }
    return write_files(folder, contents)["compare.html"]

"""``mukca report`` and ``compare``: a report of a calibration, and calibrations side by side."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from .... import recorder
from ....solver import assessment, results
from ....solver.assessment import millimetres, short_names
from ....solver.calibration import SolveOptions, UsageError
from ....solver.identification.data import check_distinct, measure
from ....solver.results import write_files
from ... import cli, report
from ...report import figures

PAGE = "report.html"


class _ReportOptions(cli.OutputOptions):
    calibration: Path
    repeatability_mm: float | None = None
    limit_mae_mm: float | None = None
    limit_distance_mm: float | None = None
    limit_between_mm: float | None = None
    known: Sequence[str] = ()
    tolerance_mm: float | None = None
    certificate: Path | None = None
    note: Sequence[str] = ()
    out: Path | None = None
    force: bool = False
    open: bool = False
    json: bool = False


def run_report(options: _ReportOptions, terminal: cli.Terminal) -> int:
    """Write the report of each arm, and show it in short."""
    report.check_certificate(options.certificate)
    return _report(options, terminal)


@cli.for_each_arm
def _report(options: _ReportOptions, terminal: cli.Terminal) -> int:
    document = results.read_calibration(options.calibration)
    lengths = SolveOptions(known=options.known).validated().distances
    limits = assessment.Options(
        repeatability=metres(options.repeatability_mm),
        mean_absolute_error=metres(options.limit_mae_mm),
        distance_error=metres(options.limit_distance_mm),
        between_placements=metres(options.limit_between_mm),
        known=lengths,
        task=metres(options.tolerance_mm),
    )
    result = assessment.assess(document, str(options.calibration), limits)
    document_of_report, files = report.build_report(result)
    sheet = options.certificate
    signed: dict[str, bytes] = {}
    if sheet:
        notes = _notes(options.note)
        kind = sheet.suffix.lower()
        content = report.certificate(document, document_of_report, kind, notes)
        signed[sheet.name] = content
        new_files(sheet.parent, signed, force=options.force)
    folder = options.out or options.calibration.parent
    written = _report_written(options, folder, files)
    report.show(terminal.console, document_of_report)
    written_with = document.provenance.output_sha256
    terminal.say(written, *results.missing_beside(options.calibration, written_with))
    if sheet:
        write_report(sheet.parent, signed, force=options.force)
        terminal.say(f"Wrote {sheet}, to print on one A4 page and to sign")
    if options.open:
        open_page(folder / PAGE, terminal)
    terminal.emit(document_of_report)
    return document_of_report.verdict.exit_status


def _notes(words: Sequence[str]) -> dict[str, str]:
    """Return notes by their keys."""
    notes: dict[str, str] = {}
    for note in words:
        key, sign, text = note.partition("=")
        if not (sign and text.strip()):
            raise UsageError(f"--note {note}: write KEY=TEXT, as in place='Hall 3'")
        notes[key.strip()] = text.strip()
    return notes


def _report_written(
    options: _ReportOptions, folder: Path, files: Mapping[str, bytes]
) -> str:
    """Write a report's files, and say so; where only a sheet is wanted, another report stays."""
    file = folder / PAGE
    only_sheet = options.certificate is not None and options.out is None
    overwrites = file.exists() and bool(_changed(folder, files))
    if only_sheet and overwrites and not (options.force or options.open):
        return f"{file} is of other options and stays as it is; --force overwrites it"
    new = write_report(folder, files, force=options.force)
    words = "and report.json beside it, the same figures for scripts"
    return f"Wrote {file}, {words}" if new else f"{file} is up to date, {words}"


def metres(length: float | None) -> float | None:
    """Length that an option in millimetres gives, None where it is not given [m]."""
    return None if length is None else length / 1e3


def write_report(folder: Path, contents: Mapping[str, bytes], *, force: bool) -> bool:
    """Write a report's files, unless they are there already; return if anything was written."""
    new = new_files(folder, contents, force=force)
    if new:
        results.write_files(folder, new)
    return bool(new)


def new_files(
    folder: Path, contents: Mapping[str, bytes], *, force: bool
) -> dict[str, bytes]:
    """Return the files that are not there yet; an OutputError if others of their names are."""
    new = _changed(folder, contents)
    results.refuse_existing(folder, new, force=force)
    return new


def _changed(folder: Path, contents: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files of which a folder has none of the same content."""
    changed: dict[str, bytes] = {}
    for name, content in contents.items():
        file = folder / name
        if not file.is_file() or file.read_bytes() != content:
            changed[name] = content
    return changed


def emit_with_page(
    options: cli.OutputOptions,
    terminal: cli.Terminal,
    lines: Sequence[str],
    result: Mapping[str, object],
    save: Callable[..., dict[str, str]] | None = None,
) -> None:
    """Write the page of a verb to its --out, in the terminal's words, and emit its result.

    ``save`` writes the results that belong to the page, as :meth:`.Calibration.save` does.
    """
    outputs = dict[str, str]()
    if options.out:
        verb = type(options).__name__.strip("_").removesuffix("Options").lower()
        values = {"title": f"mukca {verb}", "lines": lines, "result": result}
        html = report.render("found.html.j2", values, found=values)
        files = {PAGE: html.encode()}
        if save is None:
            write_report(options.out, files, force=options.force)
        else:
            outputs = save(options.out, force=options.force, pages=files)
        page = str(options.out / PAGE)
        beside = [Path(file).name for file in outputs.values() if file != page]
        outputs["report"] = page
        more = f" to read; beside it {' and '.join(beside)}" if beside else ""
        terminal.say(f"Wrote {page}{more}")
    terminal.emit({**result, "outputs": outputs})


def open_page(file: Path, terminal: cli.Terminal) -> None:
    """Show a page in the web browser; where there is no screen, as over SSH, only say so."""
    import os
    import sys
    import webbrowser

    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    screen = sys.platform != "linux" or any(os.environ.get(name) for name in screens)
    if not (screen and webbrowser.open(file.resolve().as_uri())):
        terminal.say(
            f"No browser here; copy {file.resolve()} to a computer that has one."
        )


class _CompareOptions(cli.OutputOptions):
    calibrations: Sequence[Path]
    data: Sequence[Path] = ()
    distance: float | None = None
    out: Path | None = None
    open: bool = False


def run_compare(options: _CompareOptions, terminal: cli.Terminal) -> int:
    """Compare, show the tables, and write the page."""
    options.check_out()
    contenders = figures.contenders_of(list(map(cli.one_arm, options.calibrations)))
    if options.data:
        robot = next(iter(contenders.values())).robot
        placements = recorder.read_placements(*options.data)
        data = [measure(p, robot, options.distance, sockets=1) for p in placements]
        check_distinct(data)
    else:
        data = figures.shared_data(contenders.values())
    result = figures.compare(contenders, data)
    show_comparison(terminal, result)
    if options.out:
        files = write_files(options.out, report.build_comparison(result))
        page = files["compare.html"]
        terminal.say(f"Wrote {page}")
        if options.open:
            open_page(page, terminal)
    terminal.emit(result)
    return 0


def show_comparison(
    terminal: cli.Terminal, result: "figures.ComparisonDocument"
) -> None:
    """Print the errors of every model at every placement, and the comparison in words."""
    names = short_names([row.name for row in result.placements])
    rows: list[list[str]] = []
    for name, row in zip(names, result.placements, strict=True):
        cells = [name]
        for model in row.models:
            mark = "*" if model.trained_on else " "
            cells.append(f"{millimetres(model.mean_absolute_error)}{mark}")
        rows.append(cells)
    means = [m.summary and m.summary.mean_absolute_error for m in result.models]
    head = f"= mean of {len(result.fair)} held out by all"
    rows.append([head, *(f"{millimetres(mean)} " for mean in means)])
    heads = ["placement", *(model.name for model in result.models)]
    bold = (len(rows) - 1,)
    terminal.tabulate(figures.comparison_title(result), heads, rows, bold=bold)
    terminal.say(*(figures.comparison_sentence(result, pair) for pair in result.pairs))

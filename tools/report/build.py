"""From a calibration's document to the report's two files."""

import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ..documents.files import DocumentError as CalibrationError
from .evidence import evidence_of
from .figures import Options, report_figures
from .page import page, plots_of

__all__ = ["Report", "build_report"]


_DEFAULTS = Options()


@dataclass(frozen=True)
class Report:
    """A report: its figures, and the page that shows them."""

    figures: dict[str, Any]
    html: str

    @property
    def files(self) -> dict[str, bytes]:
        """The files to write, by name."""
        return {
            "report.html": self.html.encode("utf-8", "replace"),
            "report.json": (json.dumps(self.figures, allow_nan=False) + "\n").encode(),
        }


def build_report(document: Mapping[str, Any], source: str, options: Options = _DEFAULTS) -> Report:
    """Return the report of a calibration; the same document and options give the same bytes.

    Args:
        document: As :func:`mukca.solver.calibrated.load_document` returns it.
        source: Its file, for messages.
        options: Limits, known distances, tolerance.

    Raises:
        CalibrationError: The document is damaged.
        KnownError: A known distance names no socket of the calibration.
    """
    try:
        return _build(document, source, options)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise CalibrationError(f"{source}: damaged calibration.json: {error!r}") from error


def _build(document: Mapping[str, Any], source: str, options: Options) -> Report:
    import msgspec

    document = msgspec.to_builtins(document)
    evidence = evidence_of(document, source)
    figures = report_figures(evidence, options, command_of(document))
    plots = plots_of(figures)
    figures["plots"] = [
        {"id": plot.id, "section": section, "title": plot.title, "sentence": plot.sentence}
        for section, group in plots.items()
        for plot in group
    ]
    return Report(figures, page(figures, plots))


def command_of(document: Mapping[str, Any]) -> str:
    """Return the command that makes the calibration again."""
    folders: dict[str, list[str]] = {"train": [], "test": []}
    for row in document["data"]:
        folders[row["role"]].append(str(Path(row["files"][0]).parent) if row["files"] else "?")
    words = ["mukca", "solve", *folders["train"]]
    if folders["test"]:
        words += ["--test", *folders["test"]]
    words += ["--robot", document["robot"], "--method", document["method"]]
    for key, value in document["settings"].items():
        if value not in (None, [], False):
            values = cast("list[Any]", value) if isinstance(value, list) else [value]
            words += [f"--{key.replace('_', '-')}", *([] if value is True else values)]
    return shlex.join(map(str, words))

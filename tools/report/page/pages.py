"""Pages of a report, a comparison and a simulated experiment: values for templates."""

import base64
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from ....solver.assessment import short_names
from ...experiments import SimulationDocument
from ..figures import ComparisonDocument, ReportDocument, comparison_sentence
from ..plots import Plot, comparison_plots, shown_unit, simulation_plot
from .page import render
from .tolerance import answers_by_tolerance


def report_page(report: ReportDocument, plots: Mapping[str, Sequence[Plot]]) -> str:
    """Return the report of a calibration as HTML.

    Args:
        report: The figures.
        plots: The plots by section; that of the first section stands with the answers.
    """
    (_, (table_map,)), *sections = plots.items()
    role, judged = report.summary.judged
    settings = report.provenance.settings.items()
    return render(
        "report.html.j2",
        report,
        {"by-tolerance": answers_by_tolerance(report)},
        report=report,
        names=short_names([row.name for row in report.placements]),
        role=role,
        judged=judged,
        role_name={"test": "held out", "train": "trained on"}.__getitem__,
        degrees=math.degrees(1),
        settings=", ".join(f"{k} {v}" for k, v in settings if v not in (None, [], "", False)),
        shown_unit=shown_unit,
        table_map=table_map,
        sections=[(title, group) for title, group in sections if group],
    )


def comparison_page(result: ComparisonDocument) -> str:
    """Return the comparison of calibrations as HTML."""
    return render(
        "comparison.html.j2",
        result,
        result=result,
        sentences=[comparison_sentence(result, pair) for pair in result.pairs],
        plots=comparison_plots(result),
        names=short_names([row.name for row in result.placements]),
    )


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return a simulated experiment with two models side by side as HTML.

    Args:
        result: Results with both models.
        pictures: The files' contents by name; none where they could not be made.
    """
    models = [*([] if result.beside is None else [("beside.", result.beside)]), ("", result)]
    names = [Path(model.model).name for _, model in models]
    places = [
        (place, name, f"{start}{place}.")
        for place in ("centre", "cross", "drawing")
        for name, (start, model) in zip(names, models, strict=True)
        if getattr(model, place) is not None
    ]
    return render(
        "simulation.html.j2",
        result,
        result=result,
        models=[(name, model) for name, (_, model) in zip(names, models, strict=True)],
        places=places,
        pictures={
            name: f"data:image/{name.rpartition('.')[2]};base64,{base64.b64encode(file).decode()}"
            for name, file in pictures.items()
        },
        plot=simulation_plot(result),
    )

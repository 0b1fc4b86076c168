"""Page of a simulated experiment, with both models side by side."""

import base64
from collections.abc import Mapping
from pathlib import Path

from ..report import render
from .plots import simulation_plot
from .results import ModelTrials, SimulationDocument


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return a simulated experiment with both models as HTML, and its pictures by file name."""
    models: list[tuple[str, ModelTrials]] = [("", result)]
    if result.beside is not None:
        models.insert(0, ("beside.", result.beside))
    return render(
        "simulation.html.j2",
        result,
        result=result,
        models=[(Path(model.model).name, path, model) for path, model in models],
        pictures={
            name: f"data:image/{name.rpartition('.')[2]};base64,{base64.b64encode(file).decode()}"
            for name, file in pictures.items()
        },
        plot=simulation_plot(result),
    )

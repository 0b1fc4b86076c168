"""The page of a simulated experiment: the same for any figures, with pictures or without."""

import json
import re
from pathlib import Path

import msgspec
import pytest
from kept import says

from mukca.tools.experiments import SimulationDocument, simulation_page


def result(experiment, model="calibrated"):
    """Figures of three trials, or of two lines, beside those of the nominal model."""
    figures = json.loads(Path(__file__).with_suffix(".json").read_text())[experiment]
    return msgspec.convert({**figures, "model": model}, SimulationDocument)


@pytest.mark.parametrize("experiment", ["insertion", "drawing"])
def test_the_page_says_what_it_said(experiment):
    says(experiment, simulation_page(result(experiment), {"picture.png": b"p"}))


def test_each_trial_is_drawn():
    page = simulation_page(result("insertion"), {})
    assert page.count("<circle") == 2 + 12  # the play, and each trial, of both models
    assert len(re.findall(r'class="model-\d train"', page)) == 2 + 3 + 1
    assert simulation_page(result("drawing"), {}).count("<polyline") == 4


def test_a_file_is_called_by_its_name_and_escaped():
    page = simulation_page(result("drawing", "some/where/<b>.urdf"), {})
    assert "the &lt;b&gt;.urdf model's" in page and "<b>" not in page

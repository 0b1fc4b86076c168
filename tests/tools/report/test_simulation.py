"""The page of a simulated experiment: the same for any figures, with pictures or without."""

import re

import msgspec
import pytest
from kept import says

from mukca.tools.experiments import SimulationDocument
from mukca.tools.report import simulation_page


def forces():
    return {key: {"mean": 1.25, "min": 0.5, "max": 2.0} for key in ("force", "peak_force")}


def inserted(count, miss):
    posture = {"hole": [0.5, 0.0, 0.1], "elbow": 0.5, "depth": 0.02}
    loads = {"force": 1.25, "peak_force": 2.0}
    each = [
        {"inserted": k < count, "miss": [miss, -miss, 0.0], **posture, **loads} for k in range(3)
    ]
    errors = {"tracking_error": miss, "max_tracking_error": 2 * miss}
    return {"inserted": count, "trials": 3, **errors, **forces(), "each": each}


def drawn(spread):
    line = [[0.5, 0.0], [0.51, 0.02], [0.5, 0.04]]
    errors = {"tracking_error": spread, "max_tracking_error": spread}
    apart = {"retracings": 2, "spread": spread, "max_spread": 2 * spread}
    one = {"line": line, "elbow": 0.5, "tracking_error": spread, "touching": 1.0}
    one = {**one, "force": 1.25, "peak_force": 2.0}
    return {**apart, **errors, **forces(), "each": [one, one]}


def result(experiment, model="calibrated"):
    return msgspec.convert(figures(experiment, model), SimulationDocument)


def figures(experiment, model):
    head = {"experiment": experiment, "arm": 1, "seed": 2, "model": model}
    if experiment == "drawing":
        beside = {"model": "nominal", "drawing": drawn(0.0125)}
        return {**head, "drawing": drawn(1e-4), "beside": beside}
    beside = {"model": "nominal", "centre": inserted(1, 7e-3), "cross": inserted(0, 8e-3)}
    return {
        **head,
        "hole": 0.0104,
        "centre": inserted(3, 5e-5),
        "cross": inserted(2, 2e-4),
        "beside": beside,
    }


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

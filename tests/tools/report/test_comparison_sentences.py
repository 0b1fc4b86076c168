"""Sentences of a comparison: a lead that chance does not explain, and what the models are."""

import pytest
from msgspec import structs

from mukca.tools.report import figures
from mukca.tools.report.figures import ComparisonDocument, model_comparison
from mukca.tools.report.figures.model_comparison import ComparedModel, ComparedPair, Difference
from mukca.tools.report.figures.types import Displacement


def compared(means):
    """A comparison by the differences of two models at some placements [mm]."""
    rows = tuple(
        Difference(mean=1e-3 * mean, noise=2e-4, beyond_noise=abs(mean) > 0.2) for mean in means
    )
    gap = Displacement(mean=0.0, max=0.0)
    pair = ComparedPair(
        a=0, b=1, placements=rows, summary=model_comparison._overall(rows), apart=gap
    )
    models = tuple(ComparedModel(name=name, summary=None) for name in ("old", "new"))
    return ComparisonDocument(
        format="",
        robot_name="",
        models=models,
        placements=(),
        fair=tuple(range(len(means))),
        pairs=(pair,),
        ball_refitted=False,
    )


@pytest.mark.parametrize(
    ("means", "words"),
    [
        (
            (-7.0, -8.6),
            "new is better than old by 7.800 mm over 2 placements that none was trained "
            "on, beyond the noise at each of them; they are too few, or too unlike",
        ),
        (
            (-7.0, 8.6),
            "new and old differ by 0.800 mm over 2 placements that none was trained on, "
            "which is within the spread between placements",
        ),
        ((-0.1, 0.1), "which is within the noise (noise "),
        (
            (-7.0, -7.1, -7.2),
            "beyond the noise (noise \N{PLUS-MINUS SIGN}0.248 mm, 95 %) on the whole",
        ),
    ],
)
def test_a_lead_at_every_placement_is_no_noise(means, words):
    result = compared(means)
    assert words in figures.comparison_sentence(result, result.pairs[0])


def test_what_the_models_are_is_said_above_their_errors():
    result = compared((-7.0, -8.6))
    assert figures.comparison_title(result) == "MAE in mm; * trained on"
    old, new = result.models
    full = structs.replace(new, corrected_joints=True)
    of_both = structs.replace(result, models=(old, full), ball_refitted=True)
    assert figures.comparison_title(of_both) == (
        "MAE in mm; nominal: its ball refitted to what new was trained on; "
        "new: with corrected joint positions; * trained on"
    )

"""Places to record at next, in words."""

from types import SimpleNamespace

import numpy as np

from mukca.tools.report.figures import command_lines, recommendations


def test_no_place_is_asked_for_that_lies_beside_the_others():
    """Where all of a ring round the arm is recorded, another height is left."""

    def words(angles):
        ring = [(0.5 * np.cos(a), 0.5 * np.sin(a), 0.1) for a in np.deg2rad(angles)]
        single = SimpleNamespace(predictions=SimpleNamespace(document=SimpleNamespace(arms=None)))
        single.placements = [SimpleNamespace(position=position) for position in ring]
        return recommendations._place_in_words(single)

    assert words([0]) == "about 0.50 m to its left, 0.10 m up, 0.71 m from the others"
    assert words(range(-90, 91, 20)) == "higher or lower than the others, which lie all round"


def test_a_command_names_the_folder_that_holds_its_placements_and_no_other(tmp_path):
    places = [tmp_path / "recordings" / name for name in ("front", "left")]
    for place in places:
        place.mkdir(parents=True)
        (place / "samples.csv").touch()
    both = list(map(str, places))
    assert command_lines._shortest(both) == [str(tmp_path / "recordings")]
    assert command_lines._shortest(both[:1]) == both[:1]
    assert command_lines._shortest([]) == []


def test_two_distances_of_one_base_are_named_where_they_explain_an_error():
    def steps(error):
        names = ["left", "front"]
        document = SimpleNamespace(data=[SimpleNamespace(folder=f"data/{name}") for name in names])
        errors = [SimpleNamespace(distance_error=e) for e in (error, 1e-4)]
        pairs = zip((0.1, 0.097), errors, strict=True)
        rows = [SimpleNamespace(distance=length, calibrated=e) for length, e in pairs]
        predictions = SimpleNamespace(names=names, document=document)
        single = SimpleNamespace(predictions=predictions, placements=rows)
        return list(recommendations._measure_one_base(single))

    (step,) = steps(-2.9e-3)
    assert "left says 100.0 mm and front says 97.0 mm" in step.text
    assert step.command == "mukca info data/left data/front --set-distance MEASURED"
    assert not steps(-1e-3)

"""Damaged and foreign files get one line that names the key."""

import copy
import json
import re
from pathlib import Path

import pytest
from cases import by_table

import mukca
from mukca import MukcaError

OPTIONAL = set(Path(__file__).with_name("optional_keys.txt").read_text().split())
"""What only some methods leave in the file; elsewhere it may be called the same."""
REQUIRED = {
    ("checks", 0, "where"),
    ("coefficients", 0, "standard_deviation"),
    ("uncertainty", "weak_directions", 0, "deviation"),
}
FREE = {"settings", "versions", "data_sha256", "outputs", "deflection"}
"""Whose keys are names, which may be any."""


def paths(value, path=()):
    """Every key of a document, of lists the first item's, as the way to it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield (*path, key)
            yield from paths(inner, (*path, key))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        yield from paths(value[0], (*path, 0))


def at(document, path):
    for key in path:
        document = document[key]
    return document


@pytest.fixture
def load(tmp_path):
    """Read a document as it stands in a file."""

    def load(document):
        file = tmp_path / "calibration.json"
        file.write_text(json.dumps(document))
        return mukca.load_calibration(file)

    return load


@pytest.fixture
def read(load, tmp_path):
    """Write the report of a document."""
    return lambda document: mukca.write_report(load(document), tmp_path / "out", force=True)


@pytest.fixture
def message(read, tmp_path):
    """Return the one line about a damaged document."""

    def message(document):
        with pytest.raises(MukcaError) as caught:
            read(document)
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith(f"{tmp_path / 'calibration.json'}: ")
        return str(caught.value)

    return message


@pytest.mark.slow
def test_each_key_that_is_gone_is_named(extended, load, message):
    ways = list(paths(extended))
    assert len(ways) > 120
    for path in ways:
        free = (path[0] == "provenance" and len(path) > 2) or "parameters" in path[2:3]
        if path[0] in FREE or free:
            continue
        damaged = copy.deepcopy(extended)
        del at(damaged, path[:-1])[path[-1]]
        if path[-1] in OPTIONAL and path not in REQUIRED:
            load(damaged)
        else:
            assert f"`{path[-1]}`" in message(damaged), path


def test_without_what_only_some_methods_leave_a_report_is_made(extended, read):
    for path in [*paths(extended)][::-1]:
        if path[-1] in OPTIONAL and path not in REQUIRED:
            del at(extended, path[:-1])[path[-1]]
    read(extended)


@pytest.mark.slow
def test_each_value_of_another_kind_is_named(extended, message):
    for path in paths(extended):
        damaged = copy.deepcopy(extended)
        at(damaged, path[:-1])[path[-1]] = [{"wrong": "kind"}]
        if path[0] == "settings" and len(path) > 1:
            continue
        said = message(damaged)
        names = [f"`{key}`" for key in path if isinstance(key, str)]
        assert str(path[-1]) in said or names[-1] in said or "[...]" in said, (path, said)


@by_table("path", "value", "said")
def test_parts_that_do_not_fit_each_other_are_named(document, message, path, value, said):
    at(document, path[:-1])[path[-1]] = value
    assert said in message(document)


def test_a_posterior_without_the_noise_of_its_samples_is_named(cal, message):
    document = json.loads((cal / "calibration.json").read_text())
    document["posterior"]["noises"] = {"points": [1e-4, 1e-4, 10.0]}
    assert "`posterior.noises`: none of sockets" in message(document)


@pytest.mark.parametrize("verb", ["report", "compare"])
@by_table("old", "new", "times", "said")
def test_a_file_that_cannot_be_read_gets_one_line(
    calibrated, tmp_path, refused, verb, old, new, times, said
):
    text = json.dumps(json.loads((calibrated / "calibration.json").read_text()))
    file = tmp_path / "calibration.json"
    file.write_text(re.sub(old, times * new, text, count=1, flags=re.DOTALL))
    assert str(file) in refused(said, verb, file)
    assert list(tmp_path.iterdir()) == [file]


def test_a_course_of_a_fit_below_zero_is_drawn(document, read):
    """Its terms are squares, of which the plot takes roots."""
    document["history"][0]["train"] = {"inconsistency": -1e-9, "distortion": -1e-9}
    read(document)


def test_a_folder_whose_name_is_not_utf_8_does_not_hurt(document, read):
    document["data"][0]["files"] = ["front\udcff/hole_0.csv"]
    read(document)

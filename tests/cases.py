"""Tables of cases: plain data in a JSON file beside the test that goes through them."""

import json
from pathlib import Path

import pytest


def by_table(*names):
    """Give a test the rows of its own name in the file beside its module, item by item."""

    def mark(test):
        tables = json.loads(Path(test.__code__.co_filename).with_suffix(".json").read_text())
        rows = tables[test.__name__.removeprefix("test_")]
        return pytest.mark.parametrize(names if len(names) > 1 else names[0], rows)(test)

    return mark

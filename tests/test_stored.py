"""What was stored by a release is read, and no key, name or command of it is lost."""

import json
import shutil

import pytest
import stored

SETS = sorted(stored.STORED.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("folder", SETS, ids=lambda folder: folder.name)
def test_nothing_of_a_release_is_lost(folder):
    assert stored.lost(folder) == []


@pytest.mark.slow
def test_a_key_that_is_lost_is_named(tmp_path):
    copy = shutil.copytree(SETS[-1], tmp_path / "set")
    known = json.loads((copy / "known.json").read_text())
    known["names"].append("levitate")
    next(iter(known["printed"].values()))["keys"].append(".placements[].colour")
    (copy / "known.json").write_text(json.dumps(known))
    assert [line.rpartition(" ")[2] for line in stored.lost(copy)] == [
        "mukca.levitate",
        ".placements[].colour",
    ]

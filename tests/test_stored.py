"""What was stored by a release is read, and no key, name or command of it is lost."""

import json
import shutil

import pytest
import stored

SETS = sorted(stored.STORED.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("folder", SETS, ids=lambda folder: folder.name)
def test_nothing_of_a_release_is_lost_and_what_were_is_named(folder, tmp_path):
    now = stored.told(folder)
    assert stored.lost(folder, now) == []
    copy = shutil.copytree(folder, tmp_path / "set")
    known = json.loads((copy / "known.json").read_text())
    known["names"].append("levitate")
    next(iter(known["printed"].values()))["keys"].append(".placements[].colour")
    (copy / "known.json").write_text(json.dumps(known))
    named = [line.rpartition(" ")[2] for line in stored.lost(copy, now)]
    assert named == ["mukca.levitate", ".placements[].colour"]

"""Several programs write one ``placement.json``: nothing that one wrote is lost by another."""

import fcntl
import json
import os
import subprocess
import sys
import threading
from unittest.mock import patch

import pytest

from mukca.recorder import Metadata, add_reading, lock_file, read_metadata
from mukca.recorder.session import Recording, recording_file
from mukca.solver.results import write_files

COUNT = 40
READINGS = """
import sys
from pathlib import Path
from mukca.recorder import add_reading
folder, start, count = Path(sys.argv[1]), *map(int, sys.argv[2:])
for k in range(start, start + count):
    add_reading(folder, 0.05 + 1e-6 * k)
"""


def placement(folder, table="samples.csv"):
    (folder / table).write_text("1,2\n")
    (folder / "placement.json").write_text('{"distance": 0.05, "place": "table"}')
    return folder


@pytest.mark.parametrize("table", ["samples.csv", "hole_0.csv"])
def test_no_reading_of_two_programs_is_lost(tmp_path, table):
    folder = placement(tmp_path, table)
    words = [sys.executable, "-c", READINGS, str(folder)]
    writers = [
        subprocess.Popen([*words, str(start), str(COUNT)], stderr=subprocess.PIPE, text=True)
        for start in (0, COUNT)
    ]
    errors = [writer.communicate()[1] for writer in writers]
    assert errors == ["", ""]
    metadata = json.loads((folder / "placement.json").read_text())
    readings = {round((row["distance"] - 0.05) * 1e6) for row in metadata["readings"]}
    assert readings == set(range(2 * COUNT)) and metadata["place"] == "table"
    assert sorted(file.name for file in folder.iterdir()) == sorted([table, "placement.json"])


def test_a_reading_waits_for_another_change_and_keeps_it(tmp_path):
    folder = placement(tmp_path)
    with (folder / "samples.csv").open() as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        writer = threading.Thread(target=add_reading, args=(folder, 0.0501))
        writer.start()
        (folder / "placement.json").write_text('{"distance": 0.05, "payload": 0.2}')
    writer.join()
    metadata = read_metadata(folder / "placement.json")
    assert metadata["distance"] == 0.0501 and metadata["payload"] == 0.2


def test_a_recorder_keeps_what_was_written_just_before_its_lock(tmp_path):
    folder, metadata = tmp_path / "front", Metadata("arm", ("a", "b"), ("rad", "rad"), None)
    Recording(folder, metadata).close()

    def lock_late(descriptor):
        add_reading(folder, 0.0502)
        lock_file(descriptor)

    with patch.object(recording_file, "lock_file", lock_late):
        Recording(folder, metadata).close()
    assert read_metadata(folder / "placement.json")["distance"] == 0.0502


def test_no_link_of_a_strangers_folder_is_written_through(tmp_path):
    treasure = tmp_path / "treasure"
    treasure.write_text("mine")
    folder = tmp_path / "front"
    folder.mkdir()
    placement(folder)
    for name in (".placement.json.tmp", ".placement.json"):
        (folder / name).symlink_to(treasure)
    add_reading(folder, 0.0501)
    assert treasure.read_text() == "mine"
    (folder / "placement.json").unlink()
    (folder / "placement.json").symlink_to(treasure)
    treasure.write_text("{}")
    add_reading(folder, 0.0501)
    assert treasure.read_text() == "{}"


@pytest.mark.parametrize("mask", [0o077, 0o022, 0o002])
def test_files_have_the_mode_that_the_user_asks_for(tmp_path, mask):
    before = os.umask(mask)
    try:
        Recording(tmp_path / "front", Metadata("arm", ("a",), ("rad",), 0.05)).close()
        write_files(tmp_path / "out", {"calibration.json": b"{}"})
    finally:
        os.umask(before)
    files = [file for file in tmp_path.rglob("*") if file.is_file()]
    assert [file.stat().st_mode & 0o777 for file in files] == [0o666 & ~mask] * 3
